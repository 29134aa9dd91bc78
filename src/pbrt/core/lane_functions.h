// Exponential, logarithm, sine and cosine of all wavelengths of a path at once. Loops over the lanes of a
// vector become vector code, too (special_functions.h), but load each coefficient for itself: these take two
// thirds of the time where little else is computed. tests/core/lane_functions_test.cpp holds each to what it
// says here.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

using LaneFloats = SampledSpectrum::Lanes;
using LaneInts = int32_t __attribute__((vector_size(4 * kNumWavelengths)));

inline LaneFloats MaxLanes(const LaneFloats& a, const LaneFloats& b) { return a > b ? a : b; }
inline LaneFloats MinLanes(const LaneFloats& a, const LaneFloats& b) { return a < b ? a : b; }
inline LaneFloats SqrtLanes(const LaneFloats& x) {
    LaneFloats root;
    for (int i = 0; i < kNumWavelengths; ++i) root[i] = std::sqrt(x[i]);
    return root;
}

/// e^x with a relative error below 2e-7; e^-87, which is 2e-38, below -87. @param x  not above 87
inline LaneFloats ExpOfLanes(LaneFloats x) {
    // As Exp(float), and the polynomial by Estrin's scheme.
    const LaneFloats inside = x > -87.f ? x : LaneFloats{} - 87.f;
    const LaneFloats rounded = inside * 1.44269504f + 0x1.8p23f, n = rounded - 0x1.8p23f;
    const LaneFloats r = (inside - n * 0.693359375f) + n * 2.12194440e-4f, r2 = r * r;
    const LaneFloats low = (1.f + r) + r2 * (0.50000038f + 0.16666493f * r);
    const LaneFloats p = low + r2 * r2 * (4.1656992e-2f + r * (8.3704448e-3f + 1.4473970e-3f * r));
    return std::bit_cast<LaneFloats>(std::bit_cast<LaneInts>(p) + (std::bit_cast<LaneInts>(rounded) << 23));
}

/// Of a logarithm: ln x = n ln 2 + z + rest.
struct LaneLogParts {
    LaneFloats n, z, rest;
};
/// @param x  as for Log(float), whose parts these are, with the polynomial by Estrin's scheme
inline LaneLogParts LogPartsOfLanes(LaneFloats x) {
    const auto bits = std::bit_cast<LaneInts>(x);
    const LaneInts exponent = (bits - 0x3f3504f3) >> 23;
    const LaneFloats z = std::bit_cast<LaneFloats>(bits - (exponent << 23)) - 1.f, z2 = z * z, z4 = z2 * z2;
    const LaneFloats low = (-0.499999916f + 0.333339502f * z) + z2 * (-0.250017552f + 0.199620723f * z);
    const LaneFloats high = (-0.16570509f + 0.149179728f * z) + z2 * (-0.143075152f + 0.0873483731f * z);
    return {__builtin_convertvector(exponent, LaneFloats), z, z2 * (low + z4 * high)};
}

/// Natural logarithm, relative error below 3e-7, next to x = 1 as well; 0 at 1. @param x  as for Log(float)
inline LaneFloats LogOfLanes(LaneFloats x) {
    const LaneLogParts log = LogPartsOfLanes(x);
    return log.n * 0.693359375f + (log.z + (log.rest - log.n * 2.12194440e-4f));
}

struct LaneSinCos {
    LaneFloats sin, cos;
};
/// Of n + r quarters of a turn; absolute error below 2e-7. @param r  in [-0.5, 0.5]
inline LaneSinCos SinCosOfQuarters(LaneInts n, LaneFloats r) {
    // As SinCosOfTurn(float).
    const LaneFloats r2 = r * r, r4 = r2 * r2;
    const LaneFloats sine =
        r * ((1.57079632f - 0.64596346f * r2) + r4 * (0.0796800328f - 0.00460165789f * r2));
    const LaneFloats cosine = (0.999999967f - 1.23369666f * r2) + r4 * (0.253594947f - 0.0203985817f * r2);
    // The lowest bit exchanges the two. The next one is the sign of the sine, and that of n + 1 the cosine's.
    const auto exchanges = n << 31;
    constexpr int32_t kSign = std::numeric_limits<int32_t>::min();
    const LaneFloats s = exchanges < 0 ? cosine : sine, c = exchanges < 0 ? sine : cosine;
    return {std::bit_cast<LaneFloats>(std::bit_cast<LaneInts>(s) ^ ((n << 30) & kSign)),
            std::bit_cast<LaneFloats>(std::bit_cast<LaneInts>(c) ^ (((n + 1) << 30) & kSign))};
}

}  // namespace lacquer
