// Mixtures of Gaussians over the slopes of a path's outer facets; see scale_mixture.h. All slopes of facets
// are relative ones, and all covariances those of the scale 1.
#pragma once

#include "layered/paths/lanes.h"
#include "layered/slopes/facet_map.h"
#include "layered/slopes/facet_slopes.h"
#include "pbrt/core/rng.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// The distribution of slopes as a mixture: scale t has t times the precision of scale 1.
struct SlopeScales {
    PerScale t, weight;             ///< weights sum to 1
    PerPair tOfPair, weightOfPair;  ///< those of scale j at all pairs (j, k)
    float typical;                  ///< the scale at which maps of slopes are linearised
};
/// Trowbridge and Reitz': four scales that minimise the variance of sampling the exact density by nine parts
/// of the mixture and one of the density itself, on slopes below 12 alpha. Beckmann's: one.
const SlopeScales& ScalesOf(MicrofacetModel model);

/// Where a path meets the outside.
struct PathEnd {
    Vec3 w{0, 0, 1};    ///< outside, in the convention of facet_map.h
    float toInner = 1;  ///< inner direction of the path = toInner * u
    float eta = 1;      ///< index inside over index outside
    Symmetric2 covariance{0.5f, 0, 0.5f};
    float maxAlpha = 1;  ///< of both axes
    RelativeSlopes slopes;
    const SlopeScales* scales = nullptr;

    /// The facet of a relative slope: FacetMap::BoundedDeflection().
    LinearDeflection BoundedDeflection(Slope x) const {
        return FacetMap(w, eta).BoundedDeflection(slopes.ToStack(x));
    }
};

/// The slopes of an end's visible facets. Their density, (1 + slope(w).x)+ times that of all facets, is
/// replaced at each scale by the Gaussian with the same mode, curvature and peak.
struct VisibleSlopeMixture {
    PerScale meanX, meanY;
    PerScale xx, xy, yy;  ///< precision
    PerScale peak;        ///< up to a factor that is the same for all scales

    explicit VisibleSlopeMixture(const PathEnd& end);

    /// Sum over the scales of their densities at a slope, in units of `peak`.
    float At(Slope slope) const;
};

/// An end with what its facet's distribution needs.
struct EndModel {
    PathEnd end;
    VisibleSlopeMixture facets;
    Slope mode;             ///< of the visible facets at the typical scale
    Vec3 inner;             ///< u there
    Matrix2 innerPerFacet;  ///< derivative of its slope by the facet's
    Symmetric2 precision;   ///< of the facets

    explicit EndModel(const PathEnd& pathEnd);
};

/// The facets that join the directions at the two ends, at the interface between these; or those of the end
/// that is reached last.
struct JoiningFacets {
    /// Index on the side that is drawn last over the one on the side drawn first, -1 for a reflection: see
    /// JoiningFacet.
    float kappa;
    Symmetric2 covariance;
    const SlopeScales* scales;
    RelativeSlopes slopes{};

    /// Derivative of the relative slope x of the facet that joins two directions by the slope of one of them.
    Matrix2 OverSlopeOfU(const JoiningFacet& facet, Slope x) const {
        const Matrix2 j = facet.OverSlopeOfU();
        return slopes.IsPerturbed() ? slopes.PerStack(x) * j : j;
    }
};

/// The facet of a path's one end, the directions at the other end being integrated over: all choices of
/// scales at both ends and at the interface between them.
class FirstFacet {
  public:
    FirstFacet(const EndModel& own, const EndModel& other, const JoiningFacets& joining);

    /// False if no choice has a probability that a float can tell.
    bool IsUsable() const { return total_ > kSmallestTotal && total_ < kLargestTotal; }
    Slope Sample(Rng& rng) const;
    /// Density over slopes.
    float Pdf(Slope slope) const;
    /// By how much the likeliest facets of all three events are off the usual ones: as SecondFacet's.
    float Distance() const { return distance_; }

    static constexpr float kSmallestTotal = 1e-25f, kLargestTotal = 1e30f;

  private:
    void SetMarginals(const EndModel& other, const JoiningFacets& joining, Slope residual,
                      const Matrix2& perOwn, const Matrix2& perOther);
    void SetWeights();

    const VisibleSlopeMixture& facets_;
    Slope center_;
    // For each pair (scale of the joining facets, scale at the other end) the log density of the slope
    // center + d is that of a Gaussian: log(peak) - (atCenter + 2 gradient.d + d.curvature d)/2.
    PerPair curvatureXX_, curvatureXY_, curvatureYY_, gradientX_, gradientY_, atCenter_, peak_;
    std::array<PerPair, kNumScales> weights_;  ///< for each of its own scales
    PerScale totals_;
    float total_, distance_;
};

/// The facet of an end, the direction that the joining facets lead to being known.
class SecondFacet {
  public:
    /// @param fixed  that direction, in the convention of facet_map.h
    SecondFacet(const EndModel& own, Vec3 fixed, const JoiningFacets& joining);

    /// False if maps are too far from linear, or no scale has a probability that a float can tell.
    bool IsUsable() const { return isUsable_; }
    Slope Sample(Rng& rng) const;
    /// Density over slopes.
    float Pdf(Slope slope) const;
    /// By how much the likeliest facets are off the usual ones, as a squared number of their deviations at
    /// scale 1: small in the lobes, large between directions that only wide tails join.
    float Distance() const { return distance_; }

  private:
    void SetWeights();

    const VisibleSlopeMixture& facets_;
    const SlopeScales& scales_;
    bool isUsable_ = false;
    Slope center_;
    Symmetric2 precision_;  ///< of the joining facets
    float volume_ = 0;      ///< root of its determinant
    Slope joined_;          ///< of the joining facet at the center
    Matrix2 joinedPerOwn_;  ///< derivative by the slope of the own one
    PerPair weights_;
    float total_ = 0, distance_ = 0;
};

}  // namespace lacquer::layered
