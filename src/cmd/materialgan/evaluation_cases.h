// Known materials as captures see them, for comparisons of fits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/maps.h"
#include "capture/views.h"

namespace lacquer::cmd {

/// A material that no training has seen, and whether its family was trained.
struct EvaluationCase {
    std::string family;
    capture::Maps truth;
    bool isHeldOut = false;
};
/// Every fifth is of the family that no training has seen, the others go around those that were trained.
EvaluationCase EvaluationCaseOf(int index, int size, uint64_t seed);

/// Numbers of photographs that EvaluationViews() knows.
const std::vector<int>& EvaluationCounts();
/// From above a grid of 3 x 3 places with the flash at the camera, of which `count` are taken; then eight for
/// tests, of which every other one has the light far aside.
capture::ViewSet EvaluationViews(int count);

}  // namespace lacquer::cmd
