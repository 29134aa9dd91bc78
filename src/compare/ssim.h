// SSIM: how much of an image's structure another has.
#pragma once

#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::compare {

/// Edge of the window [pixels]; an image needs that many at least in both directions.
inline constexpr int kSsimWindow = 11;

/// The mean structural similarity, [Wang et al. 2004, eq. 13 and 17], with their window (Gaussian, deviation
/// 1.5) and constants for a range of 1, over all windows that lie within the image, and over channels. 1:
/// the same; 0: unrelated. Symmetric.
/// @param channels  by name, of both images, which have one size; values as people see them (encoded), in
/// [0,1] or so. NaN and infinite values give NaN.
/// Cost: some 0.1 microseconds a value. Deterministic.
double Ssim(const Image& image, const Image& reference, const std::vector<std::string>& channels);

}  // namespace lacquer::compare
