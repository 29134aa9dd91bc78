#include "pbrt/scattering/beckmann.h"

namespace lacquer {
// The slope x along the view has the density (cos - x sin) exp(-x^2)/sqrt(pi) / ProjectedArea up to x = cot.
// In terms of b = erf(x) its integral is nearly quadratic, which gives a guess that one step of Halley's
// method mostly makes exact.
float Beckmann::SampleVisibleSlope(float sinTheta, float cosTheta, float u) {
    constexpr float kLimit = 1 - 2 * MachineEpsilon;
    const bool isSteep = cosTheta >= 4 * sinTheta;
    // As StretchedArea(), with the error function at hand.
    float end = 1, area = cosTheta;
    if (!isSteep) {
        const float cot = cosTheta / sinTheta, gaussAtEnd = Exp(-cot * cot);
        end = 1 - gaussAtEnd * ScaledErfc(cot);
        area = 0.5f * (cosTheta * (1 + end) + sinTheta * kInvSqrtPi * gaussAtEnd);
    }

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

Vec3 Beckmann::SampleVisible(Vec3 w, Point2 u) const {
    const Stretched view = Stretch(w);
    // Across the view slopes are Gaussian.
    return NormalOf(view, SampleVisibleSlope(view.sinTheta, view.cosTheta, u.x), SampleBeckmannSlope(u.y));
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
