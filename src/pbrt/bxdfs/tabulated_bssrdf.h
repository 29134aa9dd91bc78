// A BSSRDF that depends on the distance alone, from a table.
#pragma once

#include "pbrt/base/bssrdf.h"
#include "pbrt/scattering/bssrdf_table.h"

namespace lacquer {

/// Sp(po, pi) = profile(|po - pi|), by photon beam diffusion. Exit points are drawn from three discs
/// perpendicular to the axes of the entry's frame, which are pushed through the surface
/// [King et al. 2013].
class TabulatedBSSRDF final : public BSSRDF {
  public:
    /// @param p, n              entry point and its shading normal
    /// @param eta               index inside over index outside
    /// @param sigma_a, sigma_s  >= 0 [1 / unit of the scene]
    /// @param table             for eta and the mean cosine; outlives this
    TabulatedBSSRDF(Point3 p, Normal3 n, float eta, SampledSpectrum sigma_a, SampledSpectrum sigma_s,
                    const BssrdfTable& table);

    std::optional<ProbeSegment> SampleProbe(float uAxis, Point2 u) const override;
    BSSRDFValue Evaluate(Point3 p, Normal3 n) const override;
    SampledSpectrum EffectiveAlbedo() const override;
    BxDF* ExitBxDF(Arena& arena) const override;

  private:
    Point3 p_;
    Frame frame_;
    float eta_;
    SampledSpectrum sigma_t_;
    BssrdfSlice slices_[kNumWavelengths];
};

}  // namespace lacquer
