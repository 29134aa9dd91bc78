#include "layered/paths/long_paths/long_path_azimuth.h"

namespace lacquer::layered {
namespace {

/// Of density (1 + a cos psi) / 2 pi, |a| <= 1.
AzimuthSample SampleCardioid(float a, Point2 u) {
    const float psi = 2 * Pi * u.x, cosPsi = std::cos(psi), sinPsi = std::sin(psi);
    // What a uniform angle has too much of on one side belongs on the other.
    const float sign = u.y < 0.5f * (1 - a * cosPsi) ? -1.f : 1.f;
    return {sign * cosPsi, sign * sinPsi, Inv2Pi * (1 + sign * a * cosPsi)};
}

/// Below this concentration the azimuth is drawn from 1 + a cos psi, else from a Gaussian.
constexpr float kMinGaussian = 1.5f;
/// Beyond this one, the Gaussian is nothing to speak of at psi = pi.
constexpr float kNarrow = 8;

/// y = 2 sin(psi/2) has variance 1/k and is cut at +-2; near psi = pi, where dy/dpsi is 0, uniform angles
/// help out.
AzimuthSample SampleGaussian(float k, Point2 u) {
    const float uniformShare = 0.08f * std::max(0.f, (kNarrow - k) / (kNarrow - kMinGaussian));
    const float inside = k > kNarrow ? 1.f : std::erf(std::sqrt(2 * k));
    float y;
    if (u.y < uniformShare)
        y = 2 * std::sin(Pi * (u.x - 0.5f));
    else
        y = std::sqrt(2 / k) * ErfInv(std::clamp((2 * u.x - 1) * inside, -OneMinusEpsilon, OneMinusEpsilon));
    y = std::clamp(y, -2.f, 2.f);
    const float cosHalf = SafeSqrt(1 - 0.25f * y * y);
    const float gaussian = std::sqrt(k * Inv2Pi) * std::exp(-0.5f * k * y * y) * cosHalf / inside;
    return {1 - 0.5f * y * y, y * cosHalf, uniformShare * Inv2Pi + (1 - uniformShare) * gaussian};
}

}  // namespace

AzimuthSample SampleAzimuth(const Beckmann& facets, PolarAngle w1, PolarAngle w2, Point2 u) {
    const float q = w1.sin * w2.sin, p = 1 + w1.cos * w2.cos;
    const float kappa = 2 * q / Sqr(facets.AlphaX() * (w1.cos + w2.cos));
    // The square falls towards psi = 0: it takes about the slope of its logarithm from kappa.
    const float k = std::max(0.f, kappa - 2 * q / (p - 0.5f * q));
    if (k < kMinGaussian) return SampleCardioid(0.95f * std::min(1.f, k * (1 - 0.12f * k)), u);
    return SampleGaussian(k, u);
}

// The quotient is 1 + d / (b - q cos psi) with d = p - b, and its square a sum of three densities: uniform,
// of 1 / (b - q cos psi), and of the square of that. With e = q/b and cos psi = (e + cos t) / (1 + e cos t)
// the second one makes t uniform, and the third one gives it the density 1 + e cos t.
AzimuthSample SampleAzimuth(const TrowbridgeReitz& facets, PolarAngle w1, PolarAngle w2, Point2 u) {
    // b - q and b + q, free of cancellation.
    const float alpha2 = Sqr(facets.AlphaX()), cosines2 = Sqr(w1.cos + w2.cos);
    const float difference = 0.5f * (Sqr(w1.sin - w2.sin) + alpha2 * cosines2);
    const float sum = 0.5f * (Sqr(w1.sin + w2.sin) + alpha2 * cosines2);
    const float b = 0.5f * (sum + difference), q = 0.5f * (sum - difference),
                d = std::max(0.f, 0.5f * (1 - alpha2) * cosines2);
    const float e = q / b, root2 = sum * difference, root = std::sqrt(root2);  // of b^2 - q^2

    const float once = 2 * d / root, twice = d * d * b / (root2 * root), total = 1 + once + twice;
    float choice = u.y * total;
    AzimuthSample psi;
    if (choice < 1) {
        psi = SampleCardioid(0, {u.x, 0.5f});
    } else {
        choice -= 1;
        const AzimuthSample t = choice < once
                                    ? SampleCardioid(0, {u.x, 0.5f})
                                    : SampleCardioid(e, {u.x, std::min((choice - once) / twice, 1.f)});
        const float c = std::sqrt(sum) * SafeSqrt(0.5f + 0.5f * t.cos);
        const float s = std::sqrt(difference) * std::copysign(SafeSqrt(0.5f - 0.5f * t.cos), t.sin);
        const float over = 1 / (c * c + s * s);
        psi = {(c * c - s * s) * over, 2 * c * s * over, 0};
    }
    // b - q cos psi, whose least value is `difference`.
    const float denominator = difference + q * (1 - psi.cos);
    psi.pdf = Inv2Pi * Sqr(1 + d / denominator) / total;
    return psi;
}

}  // namespace lacquer::layered
