// What other textures may ask of an image texture.
#pragma once

#include <memory>

#include "pbrt/base/texture.h"

namespace lacquer {

class MipMap;

/// A copy of `texture` whose own scale is multiplied by `factor`, or null if it is no image texture.
std::unique_ptr<FloatTexture> ScaledImageMap(const FloatTexture& texture, float factor);
std::unique_ptr<SpectrumTexture> ScaledImageMap(const SpectrumTexture& texture, float factor);

/// The pyramid that `texture` looks up, or null if it is no image texture.
const MipMap* ImageOf(const FloatTexture& texture);
const MipMap* ImageOf(const SpectrumTexture& texture);

}  // namespace lacquer
