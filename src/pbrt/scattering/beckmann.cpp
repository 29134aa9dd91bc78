#include "pbrt/scattering/beckmann.h"

namespace lacquer {
namespace {

constexpr float kInvSqrtPi = 0.56418958354775628695f;

template <size_t N>
float Polynomial(float x, const float (&coefficients)[N]) {
    float value = coefficients[0];
    for (size_t i = 1; i < N; ++i) value = std::fma(value, x, coefficients[i]);
    return value;
}

}  // namespace

float ErfInv(float x) {
    static constexpr float kCentral[] = {2.81022636e-08f,  3.43273939e-07f, -3.5233877e-06f,
                                         -4.39150654e-06f, 0.00021858087f,  -0.00125372503f,
                                         -0.00417768164f,  0.246640727f,    1.50140941f};
    static constexpr float kTail[] = {-0.000200214257f, 0.000100950558f, 0.00134934322f,
                                      -0.00367342844f,  0.00573950773f,  -0.0076224613f,
                                      0.00943887047f,   1.00167406f,     2.83297682f};
    const float w = -std::log((1 - x) * (1 + x));
    return x * (w < 5 ? Polynomial(w - 2.5f, kCentral) : Polynomial(std::sqrt(w) - 3, kTail));
}

Beckmann::Stretched Beckmann::Stretch(Vec3 w) const {
    const float x = alphaX_ * w.x, y = alphaY_ * w.y;
    const float planar = std::sqrt(x * x + y * y), length = std::sqrt(planar * planar + w.z * w.z);
    if (!(planar > 0)) return {0, 1, 1, 0};
    return {planar / length, w.z / length, x / planar, y / planar};
}

// The slope x along the view has the density (cos - x sin) exp(-x^2)/sqrt(pi) / ProjectedArea up to x = cot.
// In terms of b = erf(x) its integral is nearly quadratic, which gives a guess that one step of Halley's
// method mostly makes exact.
float Beckmann::SampleVisibleSlope(float sinTheta, float cosTheta, float u) {
    constexpr float kLimit = 1 - 2 * MachineEpsilon;
    const bool isSteep = cosTheta >= 4 * sinTheta;
    const float cot = isSteep ? 4.f : cosTheta / sinTheta, end = isSteep ? 1.f : std::erf(cot);
    // As StretchedArea(), whose error function is at hand.
    const float area =
        isSteep ? cosTheta : 0.5f * (cosTheta * (1 + end) + sinTheta * kInvSqrtPi * Exp(-cot * cot));

    // exp(-x^2) is nearly 1 - k b^2 with k from pi/4 (at b = 0) to 1 (at b = +-1): for a fixed k the equation
    // is quadratic in b. A fit of k, error below 2.3e-3, and two rounds.
    const float target = 2 * u * area - cosTheta - sinTheta * kInvSqrtPi;
    float low = -kLimit, high = std::min(end, kLimit);
    const auto solveQuadratic = [&](float b) {
        const float y = b * b;
        const float k = 0.78629749f + y * (0.07625099f + y * (0.1466444f - 0.08291868f * y)) +
                        0.07244999f * Sqr(Sqr(Sqr(y)));
        const float q = 4 * k * kInvSqrtPi * sinTheta * target;
        return std::clamp(2 * target / (cosTheta + std::sqrt(std::max(cosTheta * cosTheta - q, 0.f))), low,
                          high);
    };
    // From nearly above, b is nearly uniform, and one round does.
    float b = solveQuadratic(isSteep ? 2 * u - 1 : solveQuadratic(0.6f));
    float x = ErfInv(b), gauss = Exp(-x * x);
    const auto excess = [&] {
        return 0.5f * (cosTheta * (1 + b) + sinTheta * kInvSqrtPi * gauss) - u * area;
    };

    // Halley's step in x, taken where its error is below rounding.
    const float slope = kInvSqrtPi * gauss * (cosTheta - x * sinTheta);
    const float newton = excess() / slope;
    const float halley = newton / (1 + newton * (0.5f * sinTheta / (cosTheta - x * sinTheta) + x));
    if (std::abs(halley) * (1 + std::abs(x)) < 0.01f && cosTheta - x * sinTheta > 0.2f * sinTheta)
        return x - halley;

    // Else Newton's method for b, kept in its bracket. The function is concave and rises, so the steps cannot
    // cycle.
    for (int i = 0; i < 24; ++i) {
        const float value = excess();
        if (std::abs(value) < 1e-6f * area) break;
        (value > 0 ? high : low) = b;
        const float next = b - value / (0.5f * (cosTheta - x * sinTheta));
        b = next > low && next < high ? next : 0.5f * (low + high);
        x = ErfInv(b);
        gauss = Exp(-x * x);
    }
    return x;
}

// The density cos exp(-x^2) + (-x)+ sin exp(-x^2) of a Gaussian and of a Rayleigh half, of which facets
// turned away from the view (x > 0) keep the share 1 - x tan.
float Beckmann::SampleVisibleSlope(float sinTheta, float cosTheta, float u, Rng& rng) {
    const float rayleigh = 0.5f * sinTheta, gauss = cosTheta * 1.77245385f;
    for (;; u = rng.Uniform()) {
        if (rng.Uniform() * (rayleigh + gauss) < rayleigh) return -std::sqrt(-std::log(1 - u));
        const float x = ErfInv(std::max(2 * u - 1, -1 + 2 * MachineEpsilon));
        if (x <= 0 || rng.Uniform() * cosTheta < cosTheta - x * sinTheta) return x;
    }
}

Vec3 Beckmann::NormalOf(const Stretched& view, float along, float u) const {
    // Across the view slopes are Gaussian.
    const float across = SampleBeckmannSlope(u);
    // Turn them back to the azimuth of w and stretch them.
    const float slopeX = alphaX_ * (view.cosPhi * along - view.sinPhi * across);
    const float slopeY = alphaY_ * (view.sinPhi * along + view.cosPhi * across);
    return Normalize({-slopeX, -slopeY, 1});
}

Vec3 Beckmann::SampleVisible(Vec3 w, Point2 u) const {
    const Stretched view = Stretch(w);
    return NormalOf(view, SampleVisibleSlope(view.sinTheta, view.cosTheta, u.x), u.y);
}

Vec3 Beckmann::SampleVisible(Vec3 w, Point2 u, Rng& rng) const {
    const Stretched view = Stretch(w);
    return NormalOf(view, SampleVisibleSlope(view.sinTheta, view.cosTheta, u.x, rng), u.y);
}

Point2 Beckmann::InvertVisible(Vec3 w, Vec3 wm) const {
    const Stretched view = Stretch(w);
    const float slopeX = -wm.x / wm.z * invAlphaX_, slopeY = -wm.y / wm.z * invAlphaY_;
    const float along = view.cosPhi * slopeX + view.sinPhi * slopeY;
    const float across = view.cosPhi * slopeY - view.sinPhi * slopeX;
    const float below =
        0.5f * (view.cosTheta * std::erfc(-along) + view.sinTheta * kInvSqrtPi * Exp(-along * along));
    return {below / StretchedArea(view.sinTheta, view.cosTheta), 0.5f * std::erfc(-across)};
}

}  // namespace lacquer
