// What both kinds of subjects (bsdf_subject.h, spectral_subject.h) look at: the point, and the parts of a
// mix.
#pragma once

#include <vector>

#include "pbrt/base/material.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

/// The point that textures are asked for: at the origin of space.
inline TextureContext ContextAt(Point2 uv) {
    TextureContext context;
    context.uv = uv;
    context.n = {0, 0, 1};
    return context;
}

/// Draws of a mix; the material itself, once, if it is none. A mix draws by a hash of the direction: it is
/// one if two directions ever differ.
inline std::vector<const Material*> SampleMaterials(const Material& material, const TextureContext& context) {
    constexpr int kDrawsOfMix = 64;
    Rng rng(Hash(1));
    const auto draw = [&] { return material.Choose(context, SampleUniformSphere(rng.Uniform2D())); };
    bool isMix = false;
    for (int i = 0; i < kDrawsOfMix; ++i) isMix = isMix || draw() != &material;
    if (!isMix) return {&material};
    std::vector<const Material*> drawn;
    for (int i = 0; i < kDrawsOfMix; ++i) drawn.push_back(draw());
    return drawn;
}

}  // namespace lacquer::measure
