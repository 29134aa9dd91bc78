// Eight texels that the processor treats as one, with the functions that the model takes.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "pbrt/core/lane_functions.h"

namespace lacquer::capture {

/// As many as a path carries wavelengths.
inline constexpr int kNumLanes = kNumWavelengths;
using Lanes = LaneFloats;

inline Lanes LoadLanes(const float* from) {
    Lanes x;
    std::memcpy(&x, from, sizeof(x));
    return x;
}
inline void StoreLanes(const Lanes& x, float* to) { std::memcpy(to, &x, sizeof(x)); }
inline Lanes AllLanes(float x) { return Lanes{} + x; }

/// NaN stays what it is.
inline Lanes ClampLanes(const Lanes& x, float low, float high) {
    const Lanes l = AllLanes(low), h = AllLanes(high);
    return x < l ? l : x > h ? h : x;
}

/// Logarithm to the base 2; absolute error below 3e-7 (1 + |result|).
/// @param x  positive and normal; 0 counts as some number near the smallest normal one
inline Lanes Log2Lanes(const Lanes& x) {
    const LaneLogParts log = LogPartsOfLanes(x);
    return log.n + 1.44269504F * (log.z + log.rest);
}
/// 2^x with a relative error below 3e-7, 2^-126 below -126. @param x  not above 126
inline Lanes Exp2Lanes(const Lanes& x) {
    const Lanes inside = MaxLanes(x, AllLanes(-126));
    const Lanes rounded = inside + 0x1.8p23F, r = (inside - (rounded - 0x1.8p23F)) * 0.693147181F;
    const Lanes r2 = r * r;
    const Lanes low = (1.F + r) + r2 * (0.50000038F + 0.16666493F * r);
    const Lanes p = low + r2 * r2 * (4.1656992e-2F + r * (8.3704448e-3F + 1.4473970e-3F * r));
    return std::bit_cast<Lanes>(std::bit_cast<LaneInts>(p) + (std::bit_cast<LaneInts>(rounded) << 23));
}
/// x^power for x >= 0.
inline Lanes PowLanes(const Lanes& x, float power) { return Exp2Lanes(power * Log2Lanes(x)); }

}  // namespace lacquer::capture
