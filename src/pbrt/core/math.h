// Scalars: constants and the small functions that every other file uses.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace lacquer {

inline constexpr float Pi = 3.14159265358979323846f;
inline constexpr float InvPi = 0.31830988618379067154f;
inline constexpr float Inv2Pi = 0.15915494309189533577f;
inline constexpr float Inv4Pi = 0.07957747154594766788f;
inline constexpr float PiOver2 = 1.57079632679489661923f;
inline constexpr float PiOver4 = 0.78539816339744830961f;
inline constexpr float Infinity = std::numeric_limits<float>::infinity();

/// Largest float below 1: the upper end of every uniform variate.
inline constexpr float OneMinusEpsilon = 0x1.fffffep-1f;
/// Half a unit in the last place of 1: the relative error of one rounding.
inline constexpr float MachineEpsilon = 0x1p-24f;

template <class T>
constexpr T Sqr(T x) {
    return x * x;
}
constexpr float Lerp(float t, float a, float b) { return (1 - t) * a + t * b; }
constexpr float Radians(float deg) { return deg * (Pi / 180); }
constexpr float Degrees(float rad) { return rad * (180 / Pi); }

/// e^x with a relative error below 1.5e-7; 0 below -87. Inline and without branches: loops over lanes become
/// vector code, which calls of std::exp prevent.
inline float Exp(float x) {
    // Below this the result would be denormal.
    constexpr float kLowest = -87, kHighest = 88;
    const float inside = std::clamp(x, kLowest, kHighest);
    // x = n ln 2 + r. Adding this constant rounds to an integer, which is then in the lower bits.
    constexpr float kRounder = 0x1.8p23f;
    const float rounded = std::fma(inside, 1.44269504f, kRounder), n = rounded - kRounder;
    const float r = std::fma(n, 2.12194440e-4f, std::fma(n, -0.693359375f, inside));
    // Minimax in the relative error (1.5e-8) over |r| <= ln 2 / 2.
    float p = std::fma(r, 1.4473970e-3f, 8.3704448e-3f);
    p = std::fma(r, p, 4.1656992e-2f);
    p = std::fma(r, p, 0.16666493f);
    p = std::fma(r, p, 0.50000038f);
    p = std::fma(r, p, 1.f);
    p = std::fma(r, p, 1.f);
    const float value =
        std::bit_cast<float>(std::bit_cast<int32_t>(p) + (std::bit_cast<int32_t>(rounded) << 23));
    return x < kLowest ? 0.f : value;
}

/// Angle of the finite vector (x, y) in [-pi, pi], its relative error below 3e-7; 0 for (0, 0). Inline and
/// without branches, a third of std::atan2's time.
inline float ATan2(float y, float x) {
    const float ax = std::abs(x), ay = std::abs(y);
    const float larger = std::max(ax, ay), z = larger > 0 ? std::min(ax, ay) / larger : 0.f;
    // atan(z) / z, minimax in z^2 on [0, 1] (1.5e-8).
    const float t = z * z;
    float p = std::fma(t, 2.8498685e-3f, -1.6068544e-2f);
    p = std::fma(t, p, 4.2691384e-2f);
    p = std::fma(t, p, -7.5042829e-2f);
    p = std::fma(t, p, 0.10640929f);
    p = std::fma(t, p, -0.14203644f);
    p = std::fma(t, p, 0.19992620f);
    p = std::fma(t, p, -0.33333072f);
    p = std::fma(t, p, 1.f);
    const float firstOctant = p * z;
    const float quadrant = ay > ax ? PiOver2 - firstOctant : firstOctant;
    return std::copysign(x < 0 ? Pi - quadrant : quadrant, y);
}

/// Square root of x with rounding errors below zero taken as zero.
inline float SafeSqrt(float x) { return std::sqrt(std::max(0.f, x)); }
inline float SafeASin(float x) { return std::asin(std::clamp(x, -1.f, 1.f)); }
inline float SafeACos(float x) { return std::acos(std::clamp(x, -1.f, 1.f)); }

/// Cubic Hermite step from 0 at a to 1 at b.
inline float SmoothStep(float x, float a, float b) {
    if (a == b) return x < a ? 0.f : 1.f;
    const float t = std::clamp((x - a) / (b - a), 0.f, 1.f);
    return t * t * (3 - 2 * t);
}

/// sin(x)/x, 1 at 0.
inline float SinXOverX(float x) { return 1 - x * x == 1 ? 1.f : std::sin(x) / x; }

/// a*b - c*d with the rounding error of the second product compensated (Kahan).
inline float DifferenceOfProducts(float a, float b, float c, float d) {
    const float cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

/// Bound on the relative error of n successive float operations.
constexpr float Gamma(int n) { return float(n) * MachineEpsilon / (1 - float(n) * MachineEpsilon); }

/// Largest i in [0, size-2] with pred(i) true, 0 if there is none; pred is true on a prefix. O(log size).
template <class Predicate>
int FindInterval(int size, const Predicate& pred) {
    int first = 1, length = size - 2;
    while (length > 0) {
        const int half = length / 2, middle = first + half;
        if (pred(middle)) {
            first = middle + 1;
            length -= half + 1;
        } else {
            length = half;
        }
    }
    return std::clamp(first - 1, 0, std::max(0, size - 2));
}

/// Non-negative remainder of a/b.
constexpr int Mod(int a, int b) {
    const int r = a % b;
    return r < 0 ? r + b : r;
}

constexpr int RoundUpPowerOf2(int x) {
    int p = 1;
    while (p < x) p *= 2;
    return p;
}

/// Balance between two strategies by squared densities [Veach 1997, eq. 9.14, beta = 2], one sample each.
inline float PowerHeuristic(float fPdf, float gPdf) {
    if (std::isinf(fPdf)) return 1;
    // Scaling by the larger density keeps the squares finite.
    const float m = std::max(fPdf, gPdf);
    if (!(m > 0)) return 0;
    const float f = fPdf / m, g = gPdf / m;
    return f * f / (f * f + g * g);
}

}  // namespace lacquer
