// The two reflections of light that is trapped under a rough dielectric, drawn with regard to what internal
// reflection leaves of it: almost all beyond the critical angle, a few per cent before it.
//
// Directions are turned up (z > 0): at the base both point away from it; under the coat both are turned
// round, so that what leaves the base is at once what arrives at the coat, and the other way round.
#pragma once

#include "layered/paths/long_paths/long_path_tables.h"
#include "pbrt/core/rng.h"

namespace lacquer::layered {

/// Draws directions off the base, in proportion to its reflection times an estimate of the share that the
/// coat will reflect. Both enter a density only, so that any estimate does.
template <MicrofacetDistribution Distribution>
class BaseReflection {
  public:
    /// @param alphaBase, alphaCoat  of isotropic facets, > 0
    /// @param eta                   index under the coat over index above it
    /// @param opticalThickness      that light between coat and base loses energy to, for a vertical flight
    BaseReflection(float alphaBase, float alphaCoat, float eta, float opticalThickness);

    /// A direction for `w` (unit, w.z > 0); false for a draw that meets nothing: a sample of value 0.
    /// @param pdf  density of the direction [1/sr], > 0 and finite
    bool Sample(Vec3 w, Rng& rng, Vec3* wi, float* pdf) const;

  private:
    /// Probabilities of the cells, up to a constant.
    void FillMasses(const ReflectionQuantiles::Row& row, float* masses) const;

    ReflectionQuantiles::Slice quantiles_;
    float alpha_;
    float cosCritical_, invWidth_, least_;  ///< of the estimate of the coat's share
    float opticalThickness_;
};

/// Draws directions off the coat's inside in proportion to its facets' visible area times Fresnel's factor,
/// both at once: the facet's slope across is sampled from its own distribution, and the slope along from a
/// piecewise linear density made on the spot. Accepting visible normals in proportion to Fresnel's factor
/// would need the probability of success in the weight, an integral; here each weight is exact.
template <MicrofacetDistribution Distribution>
class CoatReflection {
  public:
    /// @param alpha  of isotropic facets, > 0
    /// @param eta    index under the coat over index above it
    CoatReflection(float alpha, float eta) : facets_(alpha, alpha), eta_(eta) {}

    /// A direction for `w` (unit, w.z > 0); false for a draw that meets nothing: a sample of value 0.
    /// @param weight  f cos / density
    bool Sample(Vec3 w, Rng& rng, Vec3* wi, float* weight) const;

  private:
    Distribution facets_;
    float eta_;
};

extern template class BaseReflection<Beckmann>;
extern template class BaseReflection<TrowbridgeReitz>;
extern template class CoatReflection<Beckmann>;
extern template class CoatReflection<TrowbridgeReitz>;

}  // namespace lacquer::layered
