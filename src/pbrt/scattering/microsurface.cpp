#include "pbrt/scattering/microsurface.h"

#include <type_traits>

#include "pbrt/core/check.h"

namespace lacquer {

// ---- Facets -----------------------------------------------------------------------------------------------

FacetAreas AreasOf(const Beckmann& facets, Vec3 w) {
    constexpr float kInvSqrtPi = 0.56418958354775628695f;
    const float s = std::sqrt(Sqr(facets.AlphaX() * w.x) + Sqr(facets.AlphaY() * w.y)), c = std::abs(w.z);
    if (c >= 4 * s) return FacetAreas::At(w, c, 0);  // what is left out is below 1e-9
    const float a = c / s;
    const float below = std::max(0.f, 0.5f * (s * kInvSqrtPi * Exp(-a * a) - c * std::erfc(a)));
    return FacetAreas::At(w, c + below, below);
}

// As TrowbridgeReitz::SampleVisible(): in the stretched space the mirrored direction covers the cap
// z > -w.z evenly, which from below is small. 1 + w.z must keep its digits.
Vec3 SampleVisibleFromBelow(const TrowbridgeReitz& facets, Vec3 w, Rng& rng) {
    const Vec3 stretched{facets.AlphaX() * w.x, facets.AlphaY() * w.y, w.z};
    const Vec3 view = Normalize(stretched);
    const float height = (Sqr(view.x) + Sqr(view.y)) / (1 - view.z);  // 1 + view.z
    const Point2 u = rng.Uniform2D();
    const float oneMinusZ = u.y * height;
    const Vec3 mirrored =
        SphericalDirection(SafeSqrt(oneMinusZ * (2 - oneMinusZ)), 1 - oneMinusZ, 2 * Pi * u.x);
    const Vec3 wm{facets.AlphaX() * (mirrored.x + view.x), facets.AlphaY() * (mirrored.y + view.y),
                  height - oneMinusZ};
    const float length2 = LengthSquared(wm);
    return length2 > 0 ? wm / std::sqrt(length2) : Vec3(0, 0, 1);
}

// In the stretched space the slope y towards the view has the density (y sin - |cos|) exp(-y^2) above the
// cotangent c: a Rayleigh tail from nearly beside, else a gamma density about c, both with rejection.
Vec3 SampleVisibleFromBelow(const Beckmann& facets, Vec3 w, Rng& rng) {
    const float x = facets.AlphaX() * w.x, y = facets.AlphaY() * w.y, planar = std::sqrt(x * x + y * y);
    if (!(planar > 0)) return {0, 0, 1};
    const float c = -w.z / planar;
    float towards;
    for (;;) {
        if (c < 1) {
            towards = std::sqrt(c * c - std::log1p(-rng.Uniform()));
            if (rng.Uniform() * towards < towards - c) break;
        } else {
            const float excess = -(std::log1p(-rng.Uniform()) + std::log1p(-rng.Uniform())) / (2 * c);
            towards = c + excess;
            if (rng.Uniform() < Exp(-excess * excess)) break;
        }
    }
    const float across = SampleBeckmannSlope(rng.Uniform());
    const float cosPhi = x / planar, sinPhi = y / planar;
    return Normalize({facets.AlphaX() * (cosPhi * towards - sinPhi * across),
                      facets.AlphaY() * (sinPhi * towards + cosPhi * across), 1});
}

// ---- Depths -----------------------------------------------------------------------------------------------

MicroDepth MicroDepth::OnOtherSide() const {
    constexpr float kLn2 = 0.69314718f;
    const float t = std::max(t_, 1e-30f);
    return MicroDepth(t < kLn2 ? -std::log(-std::expm1(-t)) : -std::log1p(-std::exp(-t)));
}

void DepthFreePath::Store(const MicroRay& ray) {
    LACQUER_CHECK(numRays_ < kMaxRays);
    rates_[size_t(numRays_)] = ray.Rate();
    leadsOut_[size_t(numRays_)] = numRays_ > 0 && ray.LeadsOut();
    ++numRays_;
}

void DepthFreePath::SetEscapes(const MicroRay& ray) {
    const size_t last = size_t(numRays_ - 1);
    // Over the cosine, r_i + r_k has its inverse at hand where the ray grazes.
    for (size_t i = last + 1; i-- > 0;) {
        if (leadsOut_[i]) continue;
        const float scale = 1 / (rates_[i] * ray.cosine + ray.areas.back);
        if (i == last) {
            escape_[i] = rates_[i] * scale;
            continue;
        }
        float sum = leadsOut_[i + 1] ? 0 : rates_[i] * escape_[i + 1];
        for (size_t j = i + 2; j <= last; ++j)
            if (leadsOut_[j - 1] && !leadsOut_[j]) sum += rates_[j - 1] * p_[i][j - 1] * escape_[j];
        const float top = leadsOut_[last] ? rates_[last] * p_[i][last] : 0.f;
        escape_[i] = (sum * ray.cosine + top) * scale;
    }
}

float DepthFreePath::EscapeOverCosine(const MicroRay& ray) {
    SetEscapes(ray);
    return escape_[0];
}

void DepthFreePath::Append(const MicroRay& ray) {
    if (ray.LeadsOut()) {
        SetEscapes(ray);
        for (size_t i = 0; i < size_t(numRays_); ++i)
            if (!leadsOut_[i]) p_[i][size_t(numRays_)] = escape_[i] * ray.cosine;
        survival_ = std::max(0.f, survival_ - p_[0][size_t(numRays_)]);
    }
    Store(ray);
}

// ---- Closed forms -----------------------------------------------------------------------------------------

namespace {

/// ln Gamma(z) by Stirling's series, for z >= 6; error below 1e-8.
double StirlingLogGamma(double z) {
    const double inverse = 1 / z, square = inverse * inverse;
    return (z - 0.5) * std::log(z) - z + 0.91893853320467274 +
           inverse * (1. / 12 - square * (1. / 360 - square / 1260));
}
/// Gamma(z + 5) / Gamma(z).
double FiveFactors(double z) { return z * (z + 1) * (z + 2) * (z + 3) * (z + 4); }

}  // namespace

float OppositeShadowingRatio(float lambdaA, float lambdaB) {
    // To first order the quotient is 1 - pi^2/6 Lambda_a Lambda_b.
    if (lambdaA * lambdaB < 1e-8f) return 1;
    const float x = lambdaA, y = lambdaB, z = x + y;
    if (z < 0.1f) {
        // ln Gamma(1 + t) = -gamma t + sum of zeta(n) (-t)^n / n. With it the logarithm is a sum of
        // zeta(n) (-1)^n (x^n + y^n - z^n) / n, whose terms from the seventh power on are below 1e-8.
        const float p = x * y, d2 = -2 * p, d3 = -3 * p * z, d4 = -p * (4 * z * z - 2 * p),
                    d5 = -5 * p * z * (z * z - p), d6 = -p * (6 * Sqr(z * z) - 9 * p * z * z + 2 * p * p);
        return Exp(0.822467033f * d2 - 0.400685634f * d3 + 0.270580808f * d4 - 0.207385551f * d5 +
                   0.169557177f * d6);
    }
    const double a = 1 + std::min(double(lambdaA), 1e9), b = 1 + std::min(double(lambdaB), 1e9);
    const double sum = a + b - 1;
    return float(std::exp(StirlingLogGamma(a + 5) + StirlingLogGamma(b + 5) - StirlingLogGamma(sum + 5)) *
                 (FiveFactors(sum) / FiveFactors(a)) / FiveFactors(b));
}

namespace {

constexpr float kMinShare = 1e-5f;

/// The arguments of the fits: root mean square of the alphas, and the part of the facets that is hidden.
struct FitArguments {
    float alpha, hidden;
    template <MicrofacetDistribution Distribution>
    FitArguments(const Distribution& facets, Vec3 w)
        : alpha(std::min(std::sqrt(0.5f * (Sqr(facets.AlphaX()) + Sqr(facets.AlphaY()))), 1.f)) {
        const FacetAreas areas = AreasOf(facets, w.z > 0 ? w : -w);
        hidden = areas.back / areas.front;
    }
};

}  // namespace

// Least squares over alphas from 0.02 to 1 and angles up to 89.7 degrees.
template <MicrofacetDistribution Distribution>
float RescatteredByMetal(const Distribution& facets, Vec3 w) {
    const auto [a, y] = FitArguments(facets, w);
    const float share =
        std::is_same_v<Distribution, Beckmann>
            ? y * (0.3405f - 0.4519f * y) +
                  a * (y * (-0.2939f + 0.7253f * y) +
                       a * (0.4189f + y * (-1.4792f + 0.5183f * y) + a * (0.0430f + 0.2197f * y)))
            : y * (0.5969f - 0.7492f * y) +
                  a * (y * (-1.3198f + 2.0529f * y) +
                       a * (1.8477f + y * (-1.2005f - 1.7302f * y) + a * (-1.1770f + 1.7254f * y)));
    return std::clamp(share, kMinShare, 1.f);
}

template <MicrofacetDistribution Distribution>
float RescatteredByDielectric(const Distribution& facets, Vec3 w) {
    const auto [a, y] = FitArguments(facets, w);
    const float share =
        std::is_same_v<Distribution, Beckmann> ? a * (0.2f * a + 0.5f * y) : a * (0.25f * a + 0.6f * y);
    return std::clamp(share, kMinShare, 1.f);
}

template float RescatteredByMetal(const TrowbridgeReitz&, Vec3);
template float RescatteredByMetal(const Beckmann&, Vec3);
template float RescatteredByDielectric(const TrowbridgeReitz&, Vec3);
template float RescatteredByDielectric(const Beckmann&, Vec3);

}  // namespace lacquer
