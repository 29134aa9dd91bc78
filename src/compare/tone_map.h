// Tone maps: from linear values of any size to [0,1].
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::compare {

/// What happens to values that a screen cannot show. All take and give linear values.
enum class ToneMap {
    None,      ///< nothing
    Clamp,     ///< cut off at 0 and 1
    Reinhard,  ///< each value divided by one plus the luminance: [Reinhard et al. 2002] eq. 3
    Aces,      ///< the filmic curve of the ACES reference, as a fit: [Narkowicz 2016]
};

/// "none", "clamp", "reinhard", "aces".
std::vector<std::string> ToneMapNames();
/// By its name; empty if there is no such tone map.
std::optional<ToneMap> ParseToneMap(const std::string& name);

/// Coefficients (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5) of the ACES fit. x is 0.6 of the value, as in the
/// source, so that the curve keeps middle grey about where it was.
struct AcesCurve {
    static constexpr float kExposure = 0.6f;
    static constexpr float k0 = kExposure * kExposure * 2.51f, k1 = kExposure * 0.03f;
    static constexpr float k3 = kExposure * kExposure * 2.43f, k4 = kExposure * 0.59f, k5 = 0.14f;
    /// Of one value >= 0; in [0,1], 1 for infinity.
    static float Evaluate(float x);
    /// The value >= 0 that the curve takes to y. Domain: 0 <= y < 1.
    static double Inverse(double y);
};

/// The tone map of a colour with the given luminance. Negative values count as black but for None; infinity
/// gives 1, NaN stays NaN.
/// @param white  of Reinhard: the luminance that becomes 1 (eq. 4); 0: none does (eq. 3)
RGB Apply(ToneMap map, RGB rgb, float luminance, float white = 0);

}  // namespace lacquer::compare
