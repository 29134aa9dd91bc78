// Logarithm, sine and cosine, the error function and its inverse: inline, of known accuracy, and at a
// fraction of the time of the C library's, whose calls also keep loops over lanes from becoming vector code.
// Exp() and ATan2() are in math.h. tests/core/special_functions_test.cpp holds each to what it says here.
#pragma once

#include <array>

#include "pbrt/core/math.h"

namespace lacquer {

/// c[0] + c[1] x + c[2] x^2 + ... by Estrin's scheme: chains of dependent operations as short as the
/// logarithm of the degree.
template <size_t N>
constexpr float Polynomial(float x, const std::array<float, N>& c) {
    if constexpr (N == 1) {
        return c[0];
    } else {
        std::array<float, (N + 1) / 2> pairs{};
        for (size_t i = 0; i < N / 2; ++i) pairs[i] = std::fma(c[2 * i + 1], x, c[2 * i]);
        if constexpr (N % 2 == 1) pairs[N / 2] = c[N - 1];
        return Polynomial(x * x, pairs);
    }
}

/// Natural logarithm, relative error below 2e-7, next to x = 1 as well; 0 at 1. Without branches.
/// @param x  positive and normal. 0 and denormal numbers count as some number near the smallest normal one
inline float Log(float x) {
    // x = 2^n m, m in [sqrt(1/2), sqrt(2)).
    const auto bits = std::bit_cast<int32_t>(x);
    const int32_t exponent = (bits - 0x3f3504f3) >> 23;
    const float n = float(exponent), z = std::bit_cast<float>(bits - (exponent << 23)) - 1;
    // (ln(1 + z) - z) / z^2, minimax in the relative error of the logarithm (3e-8).
    constexpr std::array kSeries = {-0.499999916f, 0.333339502f, -0.250017552f, 0.199620723f,
                                    -0.16570509f,  0.149179728f, -0.143075152f, 0.0873483731f};
    // ln 2 in two parts, the first of which has few digits.
    const float tail = std::fma(z * z, Polynomial(z, kSeries), n * -2.12194440e-4f);
    return std::fma(n, 0.693359375f, z + tail);
}

/// Sine and cosine of one angle.
struct SinCos {
    float sin, cos;
};
/// Of the angle 2 pi u; absolute error below 1.3e-7. Without branches.
/// @param u  in [-1000, 1000]
inline SinCos SinCosOfTurn(float u) {
    // 4 u = n + r; see Exp() for the constant.
    constexpr float kRounder = 0x1.8p23f;
    const float quarters = 4 * u, rounded = quarters + kRounder, r = quarters - (rounded - kRounder);
    const auto n = std::bit_cast<uint32_t>(rounded);
    // Minimax over |r| <= 1/2, in the relative error (3e-9 and 3e-8).
    constexpr std::array kSine = {1.57079632f, -0.64596346f, 0.0796800328f, -0.00460165789f};
    constexpr std::array kCosine = {0.999999967f, -1.23369666f, 0.253594947f, -0.0203985817f};
    const float r2 = r * r, sine = r * Polynomial(r2, kSine), cosine = Polynomial(r2, kCosine);
    // Quarters exchange the two and turn their signs.
    const float s = n & 1 ? cosine : sine, c = n & 1 ? sine : cosine;
    return {n & 2 ? -s : s, (n + 1) & 2 ? -c : c};
}

/// exp(x^2) erfc(x) for x >= 0, relative error below 4e-7 up to 4 and below 2e-3 beyond, where erfc(x) is
/// below 2e-8. Without branches.
inline float ScaledErfc(float x) {
    constexpr std::array kSeries = {0.282370459f,  0.278274982f, 0.268375472f, 0.115834266f,  0.155483748f,
                                    0.0393512605f, -0.29597949f, 0.198901612f, -0.0426123209f};
    // Minimax in the relative error over x in [0, 4] (1.2e-8); so far it goes on well to infinity.
    const float t = 1 / (1 + 0.5f * x);
    return t * Polynomial(t, kSeries);
}

/// The error function; relative error below 2.5e-7, odd, +-1 at infinity. Without branches.
inline float Erf(float x) {
    const float ax = std::abs(x), x2 = x * x;
    // erf(x) / x, minimax in x^2 on [0, 1] (4e-8).
    constexpr std::array kCentral = {1.12837912f,    -0.376123262f,  0.112801801f,
                                     -0.0267113114f, 0.00491755153f, -0.000563142274f};
    const float central = ax * Polynomial(std::min(x2, 1.f), kCentral);
    const float outer = 1 - Exp(-x2) * ScaledErfc(ax);
    return std::copysign(ax < 1 ? central : outer, x);
}

/// Inverse of the error function on (-1, 1), relative error below 5e-7 [Giles 2010, table 5].
inline float ErfInv(float x) {
    constexpr std::array kCentral = {1.50140941f,     0.246640727f,    -0.00417768164f,
                                     -0.00125372503f, 0.00021858087f,  -4.39150654e-06f,
                                     -3.5233877e-06f, 3.43273939e-07f, 2.81022636e-08f};
    constexpr std::array kTail = {2.83297682f,    1.00167406f,     0.00943887047f,
                                  -0.0076224613f, 0.00573950773f,  -0.00367342844f,
                                  0.00134934322f, 0.000100950558f, -0.000200214257f};
    const float w = -Log((1 - x) * (1 + x));
    // One in 300 of uniform arguments is in the tails.
    return x * (w < 5 ? Polynomial(w - 2.5f, kCentral) : Polynomial(std::sqrt(w) - 3, kTail));
}

}  // namespace lacquer
