// Mixtures of Gaussians over the slopes of a chain's outer facets; see scale_mixture.h.
#pragma once

#include "layered/chains/half_vectors/facet_slopes.h"
#include "layered/chains/lanes.h"
#include "pbrt/core/rng.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// The distribution of slopes as a mixture: scale t has precision 2t/alpha^2 in both axes.
struct SlopeScales {
    PerScale t, weight;             ///< weights sum to 1
    PerPair tOfPair, weightOfPair;  ///< those of scale j at all pairs (j, k)
    float typical;                  ///< the scale at which maps of slopes are linearised
};
/// Trowbridge and Reitz': four scales that minimise the variance of sampling the exact density by nine parts
/// of the mixture and one of the density itself, on slopes below 12 alpha. Beckmann's: one.
const SlopeScales& ScalesOf(MicrofacetModel model);

/// Where a chain meets the outside.
struct ChainEnd {
    Vec3 w{0, 0, 1};  ///< outside, in the convention of facet_slopes.h
    Vec3 toInner{1};  ///< inner direction of the chain = toInner * u, component by component
    float eta = 1;    ///< index inside over index outside
    float alpha = 1;
    const SlopeScales* scales = nullptr;
};

/// Visible facets of an end. Their density, (1 + slope(w).x)+ times that of all facets, is replaced at each
/// scale by the Gaussian with the same mode, curvature and peak.
struct VisibleFacets {
    PerScale meanX, meanY;
    PerScale xx, xy, yy;  ///< precision
    PerScale peak;        ///< up to a factor that is the same for all scales

    explicit VisibleFacets(const ChainEnd& end);

    /// Sum over the scales of their densities at a slope, in units of `peak`.
    float At(Vec2 slope) const;
};

/// An end with what its facet's distribution needs.
struct EndModel {
    ChainEnd end;
    VisibleFacets facets;
    Vec2 mode;              ///< of the visible facets at the typical scale
    Vec3 inner;             ///< u there
    Matrix2 innerPerFacet;  ///< derivative of its slope by the facet's

    explicit EndModel(const ChainEnd& chainEnd);
};

/// The interface between the ends, or the end that is reached last.
struct Meeting {
    /// Index on the side that is drawn last over the one on the side drawn first, -1 for a reflection: see
    /// LineariseFacet().
    float kappa;
    float variance;  ///< of the slopes at scale 1
    const SlopeScales* scales;
};

/// The facet of a chain's one end, the directions at the other end being integrated over: all choices of
/// scales at both ends and at the meeting between them.
class FirstFacet {
  public:
    FirstFacet(const EndModel& own, const EndModel& other, const Meeting& meeting);

    /// False if no choice has a probability that a float can tell.
    bool IsUsable() const { return total_ > kSmallestTotal && total_ < kLargestTotal; }
    Vec2 Draw(Rng& rng) const;
    /// Density over slopes.
    float Pdf(Vec2 slope) const;

    static constexpr float kSmallestTotal = 1e-25f, kLargestTotal = 1e30f;

  private:
    void SetMarginals(const EndModel& other, const Meeting& meeting, Vec2 residual, const Matrix2& perOwn,
                      const Matrix2& perOther);
    void SetWeights();

    const VisibleFacets& facets_;
    Vec2 center_;
    // For each pair (scale at the meeting, scale at the other end) the log density of the slope center + d is
    // that of a Gaussian: log(peak) - (atCenter + 2 gradient.d + d.curvature d)/2.
    PerPair curvatureXX_, curvatureXY_, curvatureYY_, gradientX_, gradientY_, atCenter_, peak_;
    std::array<PerPair, kNumScales> weights_;  ///< for each of its own scales
    PerScale totals_;
    float total_;
};

/// The facet of an end, the direction on the other side of the meeting being known.
class SecondFacet {
  public:
    /// @param fixed  that direction, in the convention of facet_slopes.h
    SecondFacet(const EndModel& own, Vec3 fixed, const Meeting& meeting);

    /// False if maps are too far from linear, or no scale has a probability that a float can tell.
    bool IsUsable() const { return isUsable_; }
    Vec2 Draw(Rng& rng) const;
    /// Density over slopes.
    float Pdf(Vec2 slope) const;
    /// By how much the likeliest facets are off the usual ones, as a squared number of their deviations at
    /// scale 1: small in the lobes, large between directions that only wide tails join.
    float Distance() const { return distance_; }

  private:
    void SetWeights(float variance);

    const VisibleFacets& facets_;
    const SlopeScales& scales_;
    bool isUsable_ = false;
    Vec2 center_{0};
    float overVariance_ = 0;
    FacetAt meeting_;  ///< linearised at the center
    PerPair weights_;
    float total_ = 0, distance_ = 0;
};

}  // namespace lacquer::layered
