// Features of images that need no training: how much of each orientation and size there is.
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

inline constexpr int kMaxFeatureLevels = 4;

/// Levels of a Gaussian pyramid from fine to coarse. Of luminance and two opponent colours, first and second
/// derivatives of Gaussians in four orientations, a pair to a magnitude [Freeman and Adelson 1991]; the mean
/// of the level's colours is among them, too, since derivatives do not see it.
/// @param images  V x 3 x R x R
/// @return        V x 15 x R x R, and half of R for each level more while at least 8 are left
std::vector<Tensor> SteerableFeatures(const Tensor& images);

}  // namespace lacquer::materialgan
