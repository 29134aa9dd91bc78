// A rough boundary as the random surface of Smith, on which light may bounce more than once.
//
// The depth of a point is counted from the highest one on, as t = -ln C(height), C being the distribution of
// heights; its form does not matter. Along a ray in direction d a facet is hit at the rate A / |d.z| per unit
// of t, A being the area of the facets that the ray meets, projected along it [Heitz et al. 2016].
// So a surface that lets nothing through is a homogeneous half-space [Bitterli and d'Eon 2022].
#pragma once

#include <array>
#include <optional>

#include "pbrt/core/rng.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer {

/// Projected areas of the facets that are seen from w and from -w, per unit of macroscopic area. Their
/// difference is w.z. [Heitz et al. 2016]
struct FacetAreas {
    float front, back;
    /// @param above, below  areas of the facets seen from above and from below, at the angle of w
    static FacetAreas At(Vec3 w, float above, float below) {
        return w.z >= 0 ? FacetAreas{above, below} : FacetAreas{below, above};
    }
};
/// @param w  unit, on any side: seen from below are the facets that are steeper than w
FacetAreas AreasOf(const Beckmann& facets, Vec3 w);
inline FacetAreas AreasOf(const TrowbridgeReitz& facets, Vec3 w) {
    const float s2 = Sqr(facets.AlphaX() * w.x) + Sqr(facets.AlphaY() * w.y), c = std::abs(w.z);
    const float above = 0.5f * (std::sqrt(s2 + c * c) + c);
    // The difference of the two, over 2, without its rounding.
    return FacetAreas::At(w, above, above > 0 ? 0.25f * s2 / above : 0.f);
}

/// A normal with density D(wm) max(0, w.wm) / AreasOf(w).front for w.z <= 0.
/// @param w  unit, not (0, 0, -1), from which nothing is seen
Vec3 SampleVisibleFromBelow(const TrowbridgeReitz& facets, Vec3 w, Rng& rng);
Vec3 SampleVisibleFromBelow(const Beckmann& facets, Vec3 w, Rng& rng);

/// A normal that is seen from w, on any side.
template <MicrofacetDistribution Distribution>
Vec3 SampleFacet(const Distribution& facets, Vec3 w, Rng& rng) {
    return w.z > 0 ? facets.SampleVisible(w, rng.Uniform2D(), rng) : SampleVisibleFromBelow(facets, w, rng);
}

/// A ray between facets, seen from its side of the surface: z > 0 leads out.
struct MicroRay {
    Vec3 d{0, 0, 1};     ///< of flight, unit
    FacetAreas areas{};  ///< of d
    float cosine = 1;    ///< |d.z|, not 0
    /// At which facets are hit, per unit of depth.
    float Rate() const { return areas.back / cosine; }
    bool LeadsOut() const { return d.z >= 0; }

    MicroRay() = default;
    template <MicrofacetDistribution Distribution>
    MicroRay(const Distribution& facets, Vec3 direction)
        : d(direction), areas(AreasOf(facets, direction)), cosine(std::max(std::abs(direction.z), 1e-12f)) {}
};

/// How deep a walk is, by flights of random length.
class MicroDepth {
  public:
    explicit MicroDepth(float t = 0) : t_(t) {}
    /// Flies to the next facet; from outside, where t = 0, to the first one. False if the ray leaves.
    bool Fly(const MicroRay& ray, Rng& rng) {
        const float step = -Log(1 - rng.Uniform()) / ray.Rate();
        t_ = ray.LeadsOut() ? t_ - step : t_ + step;
        return t_ > 0 || !ray.LeadsOut();
    }
    /// The depth of the same point on the other side of the surface: -ln(1 - C).
    MicroDepth OnOtherSide() const;
    /// Probability of leaving along a ray that leads out, over its cosine.
    float EscapeOverCosine(const MicroRay& ray) const { return std::exp(-t_ * ray.Rate()) / ray.cosine; }

  private:
    float t_;
};

/// How probably a walk leaves whose directions are known and whose depths are not: all depths are integrated
/// over [Bitterli and d'Eon 2022]. On one side of the surface, which lets nothing through.
///
/// The integral follows from the principle of invariance, as in [Cui et al. 2023]: nothing changes if the
/// half-space gets a thin layer on top. What the layer takes away along the outer directions d_0 and d_k it
/// gives back where one vertex of the path lies in the layer, so that what precedes it and what follows it
/// are paths of their own. With r the rates, P(i..k) the probability that a walk that enters along d_i goes
/// on along d_i+1 ... d_k and leaves, and sums over the vertices that can be on top:
///   (r_i + r_k) P(i..k) = r_i [d_i+1 leads in] P(i+1..k) + r_k-1 [d_k-1 leads out] P(i..k-1)
///                         + sum_j r_j-1 [d_j-1 leads out, d_j leads in] P(i..j-1) P(j..k),
/// and r_i alone on the right for k = i + 1. All terms are positive. Time and memory: the square of the
/// number of directions for each new one.
class DepthFreePath {
  public:
    static constexpr int kMaxRays = 32;

    /// @param first  leads in, from outside
    explicit DepthFreePath(const MicroRay& first) { Store(first); }
    int NumRays() const { return numRays_; }
    /// Probability that the walk gets to the facet at the end of its last ray.
    float Survival() const { return survival_; }
    /// Probability that it gets there and leaves along `ray`, over the ray's cosine.
    float EscapeOverCosine(const MicroRay& ray);
    /// Goes on along `ray`; there must be room.
    void Append(const MicroRay& ray);

  private:
    void Store(const MicroRay& ray);
    /// Sets escape_[i] to P(i..ray) / ray.cosine for all i that lead in.
    void SetEscapes(const MicroRay& ray);

    int numRays_ = 0;
    float survival_ = 1;
    std::array<float, kMaxRays> rates_;
    std::array<bool, kMaxRays> leadsOut_;
    std::array<float, kMaxRays> escape_;
    std::array<std::array<float, kMaxRays>, kMaxRays> p_;  ///< [i][k] = P(i..k), d_i in and d_k out
};

/// Joint shadowing of two directions on opposite sides of a surface, over that of two on the same side,
/// 1/(1 + Lambda_a + Lambda_b): it is the beta function B(1 + Lambda_a, 1 + Lambda_b), since points that are
/// low on one side are high on the other one [Heitz et al. 2016]. In (0, 1].
float OppositeShadowingRatio(float lambdaA, float lambdaB);

/// About what part of the light that arrives along w does not leave after its first event at the facets, for
/// densities: of metals within 0.1 up to alphas of 1, of dielectrics, where it depends on the index, too,
/// within 0.4 (0.14 in the mean). At least 1e-5, at most 1.
template <MicrofacetDistribution Distribution>
float RescatteredByMetal(const Distribution& facets, Vec3 w);
template <MicrofacetDistribution Distribution>
float RescatteredByDielectric(const Distribution& facets, Vec3 w);

}  // namespace lacquer
