// Parameters that every filter has.
#pragma once

#include "pbrt/base/filter.h"

namespace lacquer {

/// Largest half extent of a filter [pixels].
inline constexpr float kMaxFilterRadius = 64;

/// "float xradius", "float yradius". Errors: SceneError unless both lie in (0, kMaxFilterRadius].
inline Vec2 ReadFilterRadius(const Params& params, float fallback) {
    constexpr float kMinFilterRadius = 1e-6f;
    return {params.GetFloatInRange("xradius", fallback, kMinFilterRadius, kMaxFilterRadius),
            params.GetFloatInRange("yradius", fallback, kMinFilterRadius, kMaxFilterRadius)};
}

/// A factor that must be positive and sane.
inline float ReadFilterWidth(const Params& params, const char* name, float fallback) {
    return params.GetFloatInRange(name, fallback, 1e-6f, 1e3f);
}

}  // namespace lacquer
