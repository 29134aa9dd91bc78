// The image that a light projects.
#pragma once

#include <memory>

#include "pbrt/base/light.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// The image of `"string filename"`; its 8-bit values are sRGB. Errors: SceneError if the parameter is
/// missing or a value is not finite, and those of ReadImage.
std::shared_ptr<const Image> ReadLightImage(const LightArgs& args);

/// Errors: SceneError at "filename" for a value of the first `channels` channels that is NaN or infinite.
void RequireFinitePixels(const Params& params, const std::string& filename, const Image& image, int channels);

/// Which of n texels in a row a coordinate in [0,1] falls into; 0 for one that is not a number.
inline int NearestTexel(float x, int n) {
    // In this order, a NaN loses the first comparison.
    return int(std::min(std::max(0.f, x * float(n)), float(n - 1)));
}

}  // namespace lacquer
