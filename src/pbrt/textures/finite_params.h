// Parameters of textures that must be ordinary numbers.
#pragma once

#include <limits>

#include "pbrt/core/params.h"

namespace lacquer {

/// A float that is neither NaN nor infinite. Errors: SceneError.
inline float FiniteFloat(const Params& params, std::string_view name, float fallback) {
    constexpr float kHuge = std::numeric_limits<float>::max();
    return params.GetFloatInRange(name, fallback, -kHuge, kHuge);
}

/// A vector of such components. Errors: SceneError.
inline Vec3 FiniteVector3(const Params& params, std::string_view name, Vec3 fallback) {
    const Vec3 value = params.GetVector3(name, fallback);
    if (!IsFinite(value))
        params.Fail(name, "\"vector3 " + std::string(name) + "\" must have finite components");
    return value;
}

}  // namespace lacquer
