// Reflection as it was measured, in the adaptive parametrisation of the RGL database.
#pragma once

#include <memory>

#include "pbrt/base/bxdf.h"
#include "pbrt/bxdfs/bilinear_warp.h"
#include "pbrt/core/error.h"

namespace lacquer {

/// A measured BRDF [Dupuy and Jakob 2018]: facets are drawn by the visible normals that were estimated for
/// this surface, and what is left is a smooth spectrum over the numbers that draw them. Immutable.
class MeasuredBrdf {
  public:
    /// Reads a .bsdf file. Files that hold a part of the azimuths only are refused.
    /// Errors: as TensorFile; SceneError at `loc` for fields that do not fit together.
    static std::shared_ptr<const MeasuredBrdf> Read(const std::string& path, const FileLoc& loc);

    /// f and the density of what Sample() draws [1/sr]; both directions above the surface. f is not
    /// reciprocal: no more than measured data are.
    struct Value {
        SampledSpectrum f;
        float pdf = 0;
    };
    Value Evaluate(Vec3 wo, Vec3 wi, SampledSpectrum lambda) const;
    float Pdf(Vec3 wo, Vec3 wi) const;
    /// A direction for a uniform u; below the surface if the draw fails.
    Vec3 Sample(Vec3 wo, Point2 u) const;

  private:
    /// A pair of directions in the coordinates of the tables.
    struct Coordinates;
    Coordinates CoordinatesOf(Vec3 wo, Vec3 wi) const;

    std::vector<float> theta_, phi_, wavelengths_;  // of wo [radians]; [nm]
    BilinearTables ndf_, sigma_, spectra_;
    BilinearWarp vndf_, luminance_;
    bool isotropic_ = true;
};

/// Both sides of the surface reflect alike.
class MeasuredBxDF final : public BxDF {
  public:
    MeasuredBxDF(const MeasuredBrdf& brdf, const SampledWavelengths& lambda)
        : brdf_(&brdf), lambda_(lambda.Lambda()) {}

    Lobes Flags() const override { return Lobes::GlossyReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    const MeasuredBrdf* brdf_;
    SampledSpectrum lambda_;
};

}  // namespace lacquer
