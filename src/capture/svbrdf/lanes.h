// Eight texels that the processor treats as one, with the functions that the model takes.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace lacquer::capture {

inline constexpr int kNumLanes = 8;
using Lanes = float __attribute__((vector_size(4 * kNumLanes)));
using LaneInts = int32_t __attribute__((vector_size(4 * kNumLanes)));

inline Lanes LoadLanes(const float* from) {
    Lanes x;
    std::memcpy(&x, from, sizeof(x));
    return x;
}
inline void StoreLanes(const Lanes& x, float* to) { std::memcpy(to, &x, sizeof(x)); }
inline Lanes AllLanes(float x) { return Lanes{} + x; }

inline Lanes MaxLanes(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
inline Lanes MinLanes(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
/// NaN stays what it is.
inline Lanes ClampLanes(const Lanes& x, float low, float high) {
    const Lanes l = AllLanes(low), h = AllLanes(high);
    return x < l ? l : x > h ? h : x;
}
inline Lanes SqrtLanes(const Lanes& x) {
    Lanes root;
    for (int i = 0; i < kNumLanes; ++i) root[i] = std::sqrt(x[i]);
    return root;
}

/// As Log(float) of pbrt/core/special_functions.h, over ln 2; absolute error below 3e-7 (1 + |result|).
/// @param x  positive and normal; 0 counts as some number near the smallest normal one
inline Lanes Log2Lanes(const Lanes& x) {
    const auto bits = std::bit_cast<LaneInts>(x);
    const LaneInts exponent = (bits - 0x3f3504f3) >> 23;
    const Lanes n = __builtin_convertvector(exponent, Lanes);
    const Lanes z = std::bit_cast<Lanes>(bits - (exponent << 23)) - 1.F, z2 = z * z, z4 = z2 * z2;
    const Lanes low = (-0.499999916F + 0.333339502F * z) + z2 * (-0.250017552F + 0.199620723F * z);
    const Lanes high = (-0.16570509F + 0.149179728F * z) + z2 * (-0.143075152F + 0.0873483731F * z);
    return n + 1.44269504F * (z + z2 * (low + z4 * high));
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
