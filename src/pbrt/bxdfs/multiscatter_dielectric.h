// Reflection and refraction by a rough boundary with all bounces between its facets.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microsurface.h"

namespace lacquer {

/// DielectricBxDF and the light that meets more than one facet, on the random surface of Smith [Heitz et al.
/// 2016]: light changes sides at each facet that it passes, and nothing is lost. Never smooth.
///
/// A value is the closed form of single events plus an estimate of the others, which needs context.rng: a
/// walk from wo or from wi with a connection at each facet; the two starts are weighted by the balance
/// heuristic. Single transmission is that of DielectricBxDF times OppositeShadowingRatio(): what is hidden
/// from above is seen from below, which the usual shadowing factor leaves out. Sample() is the analog walk.
/// The density is an approximation (pdfExact is false): the exact one of what leaves after one event, and
/// cosine lobes for all else. Positive wherever Sample() draws; its integral is 0.66 to 1.5 up to alphas
/// of 1. Model() is none: product estimators know single events only.
template <MicrofacetDistribution Distribution>
class MultiscatterDielectricBxDF final : public BxDF {
  public:
    /// Events after which light is lost: less than 1e-4 of it at alphas up to 10.
    static constexpr int kMaxEvents = 256;

    /// @param alphas     not smooth
    /// @param eta        as for DielectricBxDF, not 1
    /// @param maxEvents  1 to kMaxEvents; fewer lose energy
    MultiscatterDielectricBxDF(Alphas alphas, float eta, int maxEvents = kMaxEvents)
        : facets_(alphas.x, alphas.y), eta_(eta), maxEvents_(maxEvents) {}

    Lobes Flags() const override { return Lobes::BothSides | Lobes::Glossy; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    void Regularize() override;

  private:
    /// A walk between facets. Its directions are turned to their opposites while it is below the surface,
    /// where the facets then have the same normals.
    struct Walk {
        float side;  ///< 1 above, -1 below
        MicroRay ray;
        MicroDepth depth;
    };
    /// f of one event, for importance, and with exchanged directions.
    struct SingleEvent {
        float f = 0, fReverse = 0;
    };

    static float SideOf(Vec3 w) { return w.z > 0 ? 1.f : -1.f; }
    Walk StartAt(Vec3 wo) const { return {SideOf(wo), MicroRay(facets_, -SideOf(wo) * wo), MicroDepth()}; }
    /// Index on the other side over index on this one.
    float IndexAcross(float side) const { return side > 0 ? eta_ : 1 / eta_; }
    /// Joint density of the facet with normal wm and of what it does with w, per solid angle of `to`, times
    /// the area of the facets that w sees. @param to  z > 0 or not: reflected is what stays before the facet
    float TurnDensity(float side, Vec3 w, Vec3 wm, Vec3 to, bool isReflected) const;
    /// Density of a walk's next direction if the light of wi came from there [1/sr].
    float TurnTowards(const Walk& walk, Vec3 wi) const;
    /// Lets a walk meet the facet wm and turn. False if it cannot.
    bool TurnAt(Vec3 wm, bool isReflected, Walk& walk) const;
    /// f of two and more events, for importance.
    float EstimateRescattered(Vec3 wo, Vec3 wi, Rng& rng) const;
    SingleEvent SingleEventOf(Vec3 wo, Vec3 wi) const;
    float DensityOf(float single, Vec3 wo, Vec3 wi) const;
    /// Probability with which the first facet reflects, where `sides` are asked for.
    float ReflectionProbability(float fresnel, Vec3 w, Lobes sides) const;

    Distribution facets_;
    float eta_;
    int maxEvents_;
};

extern template class MultiscatterDielectricBxDF<TrowbridgeReitz>;
extern template class MultiscatterDielectricBxDF<Beckmann>;

}  // namespace lacquer
