// All measurements of a material: what `lacquer bsdf` shows.
#pragma once

#include <string>
#include <vector>

#include "measure/bsdf_result.h"

namespace lacquer::measure {

struct BsdfSurveyOptions {
    double thetaDeg = 45, phiDeg = 0;  ///< where the light comes from
    int resolution = 256;              ///< pixels on a side of the images
    int samples = 32;                  ///< evaluations of a pixel; other counts grow with it
    int seed = 0;
};

/// One way to evaluate the material.
struct NamedBsdf {
    std::string name;
    const BsdfSubject* bsdf = nullptr;
};

/// Samples the material by the first of `estimators`, and evaluates it by each of them.
/// @param estimators  at least one, all of one material
/// @param observer  is told of the progress: first of the samples, then of each estimator; may be null
/// Cost: some 10 s on two cores for a stack of two interfaces and all estimators. The result is the same for
/// the same seed whatever the threads, but for EvaluationCost, which is measured by the clock.
BsdfResult SurveyBsdf(const BsdfSurveyOptions& options, const std::vector<NamedBsdf>& estimators,
                      Observer* observer);

/// True for what an estimator and a density can be chosen for.
bool IsLayered(const BsdfSubject& bsdf);

/// The direction at these angles [degrees].
Vec3 DirectionAt(double thetaDeg, double phiDeg);

}  // namespace lacquer::measure
