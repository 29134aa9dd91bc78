// What other textures may ask of an image texture.
#pragma once

#include <memory>

#include "pbrt/base/texture.h"

namespace lacquer {

/// A copy of `texture` whose own scale is multiplied by `factor`, or null if it is no image texture.
std::unique_ptr<FloatTexture> ScaledImageMap(const FloatTexture& texture, float factor);
std::unique_ptr<SpectrumTexture> ScaledImageMap(const SpectrumTexture& texture, float factor);

}  // namespace lacquer
