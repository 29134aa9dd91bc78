// A sheet of mirror flakes in a clear binder: the effect pigments of car paint.
#pragma once

#include <optional>

#include "pbrt/base/bxdf.h"
#include "pbrt/bxdfs/flake_optics.h"
#include "pbrt/scattering/flake_field.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/slopes.h"

namespace lacquer {

/// The flakes in a window of the sheet.
struct FlakesInWindow {
    FlakeField field;
    FlakeWindow window;
    /// Area of a flake over that of the window, in which the centres of flakes are counted. They overlap by
    /// chance.
    float areaShare;
    /// Share of the whole sheet under flakes; given only where the sheet lies in a stack.
    std::optional<float> sheetCoverage = {};
};

/// The slope of a flake's normal, of flakes whose normals have the distribution.
template <MicrofacetDistribution Distribution>
Slope SlopeOfFlake(const Flake& flake, const Distribution& normals);

/// Reflection by flakes whose normals are distributed as those of microfacets. Where the flakes of the
/// window are few, only those are there [Jakob et al. 2014, eq. 9]: normals have the distribution
///
///   D(wm) = 1/n sum_i k(slope of wm - slope of flake i) / cos^4,
///
/// where each flake is a mirror that is rough of itself, by a kernel k over slopes. Light that no flake meets
/// goes straight on. Over all windows the mean of f is that of the microfacets times the coverage, whatever
/// the windows' size; so is that of the energy, which in a single window, where flakes happen to face one
/// direction, may be above 1 for that direction.
///
/// In a stack light comes back through other gaps than it went in by, and meets other flakes on its way.
/// Products of what one window has would depend on its size, so in a stack flakes are counted for light that
/// comes from above alone: gaps, and flakes seen from below, are those of the whole sheet. Elsewhere both
/// sides are alike.
template <MicrofacetDistribution Distribution>
class FlakesBxDF final : public BxDF {
  public:
    /// @param alphas     of the flakes' normals
    /// @param roughness  radius of the kernel, as a slope, > 0
    FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics, const FlakesInWindow& flakes);
    /// Without end many flakes. @param coverage  in [0, 1]
    FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics, float coverage);

    Lobes Flags() const override;
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    /// Flakes without end, which are wider spread.
    void Regularize() override;

  private:
    /// Normals of facets about a direction: their density over slopes, and what they reflect.
    struct Facets {
        float density = 0;
        SampledSpectrum reflectance;
    };
    /// What a side of the sheet has.
    struct Side {
        bool isCounted = false;  ///< else there are flakes without end
        float coverage = 0;
        float reflectionProbability = 1;  ///< of Sample(), where both sides are asked for
    };
    /// Without what either kind of flakes has of its own.
    FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics);
    /// @param reflectance  of a flake, about
    Side SideWith(bool isCounted, float coverage, float reflectance) const;
    const Side& SideOf(Vec3 w) const { return w.z > 0 ? above_ : below_; }
    /// Probability of Sample() to draw a reflection.
    float ReflectionProbability(const Side& side, const BxDFContext& context) const;
    Facets FacetsAbout(Slope slope, float cosTheta_d, bool isCounted) const;
    FlakeNormals NormalsAbout(Slope slope) const;
    /// The slope of a facet. @param pick  in [0,1), of the flake
    Slope SampleFacet(bool isCounted, float pick, const BxDFRandom& u) const;
    BxDFSample SampleTransmission(Vec3 wo, const BxDFRandom& u, float probability) const;

    Distribution flakes_;  ///< of the flakes' normals
    Distribution facets_;  ///< the same with their roughness
    float roughness_;
    FlakeOptics optics_;
    std::optional<FlakesInWindow> discrete_;  ///< none: without end many
    int count_ = 0;
    float passing_ = 0;  ///< coverage for light that goes straight on
    Side above_, below_;
};

extern template Slope SlopeOfFlake(const Flake& flake, const TrowbridgeReitz& normals);
extern template Slope SlopeOfFlake(const Flake& flake, const Beckmann& normals);
extern template class FlakesBxDF<TrowbridgeReitz>;
extern template class FlakesBxDF<Beckmann>;

}  // namespace lacquer
