#include "slope_samplers.h"

#include <array>
#include <bit>

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/core/rng.h"

namespace lacquer::bench {
namespace {

constexpr float kInvSqrtPi = 0.56418958354775628695f;

/// Draws a facet by `along(sinTheta, cosTheta)`, which draws the slope along the view w stretched to alpha =
/// 1 with the density (cosTheta - x sinTheta)+ exp(-x^2), not normalised. Across the view slopes are
/// Gaussian.
template <class SampleAlong>
Vec3 SampleFacet(const Beckmann& facets, Vec3 w, float uAcross, const SampleAlong& drawAlong) {
    const float viewX = facets.AlphaX() * w.x, viewY = facets.AlphaY() * w.y;
    const float planar = std::sqrt(viewX * viewX + viewY * viewY);
    const float cosPhi = planar > 0 ? viewX / planar : 1, sinPhi = planar > 0 ? viewY / planar : 0;
    const float invLength = 1 / std::sqrt(planar * planar + w.z * w.z);
    const float along = drawAlong(planar * invLength, w.z * invLength);
    const float across = SampleBeckmannSlope(uAcross);
    return Normalize({-facets.AlphaX() * (cosPhi * along - sinPhi * across),
                      -facets.AlphaY() * (sinPhi * along + cosPhi * across), 1});
}

/// Newton's method for b = erf(slope) in its bracket, from the guess that b is uniform.
float NewtonSlope(float sinTheta, float cosTheta, float u) {
    constexpr float kLimit = 1 - 2 * MachineEpsilon;
    float low = -kLimit, high = sinTheta > 0 ? std::min(std::erf(cosTheta / sinTheta), kLimit) : kLimit;
    const auto areaBelow = [&](float b, float gauss) {
        return 0.5f * (cosTheta * (1 + b) + sinTheta * kInvSqrtPi * gauss);
    };
    const float cot = sinTheta > 0 ? std::min(cosTheta / sinTheta, 10.f) : 10.f;
    const float area = areaBelow(std::erf(cot), std::exp(-cot * cot));
    float b = std::lerp(low, high, u), x = 0;
    for (int i = 0; i < 50; ++i) {
        x = ErfInv(b);
        const float excess = areaBelow(b, std::exp(-x * x)) / area - u;
        if (std::abs(excess) < 1e-5f) break;
        (excess > 0 ? high : low) = b;
        const float next = b - excess * area / (0.5f * (cosTheta - x * sinTheta));
        b = next > low && next < high ? next : 0.5f * (low + high);
    }
    return x;
}

}  // namespace

std::span<const NamedSlopeSampler> SlopeSamplers() {
    static constexpr std::array<NamedSlopeSampler, 4> kSamplers = {{{SlopeSampler::Library, "library"},
                                                                    {SlopeSampler::Control, "control"},
                                                                    {SlopeSampler::Newton, "newton"},
                                                                    {SlopeSampler::Rejection, "rejection"}}};
    return kSamplers;
}

Vec3 SampleVisibleByNewton(const Beckmann& facets, Vec3 w, Point2 u) {
    return SampleFacet(facets, w, u.y,
                       [&](float sinTheta, float cosTheta) { return NewtonSlope(sinTheta, cosTheta, u.x); });
}

// The numbers beyond the two given come from their bits: one step of a generator each, as if one were at
// hand.
Vec3 SampleVisibleByRejection(const Beckmann& facets, Vec3 w, Point2 u) {
    Rng rng(uint64_t(std::bit_cast<uint32_t>(u.x)) << 32 | std::bit_cast<uint32_t>(u.y));
    return facets.SampleVisible(w, u, rng);
}

Vec3 SampleVisible(SlopeSampler sampler, const Beckmann& facets, Vec3 w, Point2 u) {
    switch (sampler) {
        case SlopeSampler::Newton:
            return SampleVisibleByNewton(facets, w, u);
        case SlopeSampler::Rejection:
            return SampleVisibleByRejection(facets, w, u);
        default:
            return facets.SampleVisible(w, u);
    }
}

namespace {

/// A boundary of the library whose Sample() draws the facets in another way. Values and densities are the
/// library's.
template <class Boundary, SlopeSampler sampler>
class Resampled final : public BxDF {
  public:
    /// @param eta  index below over index above; 0: lets nothing through
    Resampled(const Boundary& boundary, Alphas alphas, float eta)
        : boundary_(boundary), facets_(alphas.x, alphas.y), eta_(eta) {}

    Lobes Flags() const override { return boundary_.Flags(); }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override {
        return boundary_.Evaluate(wo, wi, context);
    }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u,
                                     const BxDFContext& context) const override {
        if (wo.z == 0) return std::nullopt;
        const Vec3 wm = SampleVisible(sampler, facets_, wo.z < 0 ? -wo : wo, u.direction);
        // The side, by energy among those asked for.
        const bool reflects = Any(context.sides, Lobes::Reflection);
        const bool transmits = eta_ > 0 && Any(context.sides, Lobes::Transmission);
        bool isReflected = reflects;
        if (reflects && transmits) isReflected = u.lobe < FresnelDielectric(Dot(wo, wm), eta_);
        if (!isReflected && !transmits) return std::nullopt;
        // The direction, and its value as Evaluate() has it.
        BxDFSample sample;
        sample.wi = Reflect(wo, wm);
        sample.lobe = Lobes::GlossyReflection;
        if (!isReflected) {
            const std::optional<Refraction> refracted = Refract(wo, wm, eta_);
            if (!refracted) return std::nullopt;
            sample.wi = refracted->w;
            sample.lobe = Lobes::GlossyTransmission;
            sample.eta = wo.z > 0 ? eta_ : 1 / eta_;
        }
        sample.wi = Normalize(sample.wi);
        if (SameHemisphere(wo, sample.wi) != isReflected) return std::nullopt;
        const BxDFValue value = boundary_.Evaluate(wo, sample.wi, context);
        if (!(value.pdf > 0)) return std::nullopt;
        sample.weight = value.f * (std::abs(sample.wi.z) / value.pdf);
        sample.pdf = value.pdf;
        sample.pdfReverse = value.pdfReverse;
        return sample;
    }
    SurfaceModel Model() const override { return boundary_.Model(); }

  private:
    Boundary boundary_;
    Beckmann facets_;
    float eta_;
};

template <class Boundary>
BxDF* NewResampled(Arena& arena, SlopeSampler sampler, const Boundary& boundary, Alphas alphas, float eta) {
    switch (sampler) {
        case SlopeSampler::Library:
            return arena.New<Boundary>(boundary);
        case SlopeSampler::Control:
            return arena.New<Resampled<Boundary, SlopeSampler::Control>>(boundary, alphas, eta);
        case SlopeSampler::Newton:
            return arena.New<Resampled<Boundary, SlopeSampler::Newton>>(boundary, alphas, eta);
        case SlopeSampler::Rejection:
            return arena.New<Resampled<Boundary, SlopeSampler::Rejection>>(boundary, alphas, eta);
    }
    return nullptr;
}

}  // namespace

BxDF* NewDielectric(Arena& arena, SlopeSampler sampler, Alphas alphas, float eta) {
    return NewResampled(arena, sampler, DielectricBxDF<Beckmann>(alphas, eta), alphas, eta);
}

BxDF* NewConductor(Arena& arena, SlopeSampler sampler, Alphas alphas, SampledSpectrum eta,
                   SampledSpectrum k) {
    return NewResampled(arena, sampler, ConductorBxDF<Beckmann>(alphas, eta, k), alphas, 0.f);
}

}  // namespace lacquer::bench
