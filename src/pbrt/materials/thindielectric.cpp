// Material "thindielectric": a thin sheet of glass, always smooth.
//
//   "float eta" or "spectrum eta"  1.5  index of the sheet over index around it
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/base/material.h"
#include "pbrt/materials/index_of_refraction.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer {
namespace {

/// Two parallel smooth boundaries at once: mirror reflection and undeviated transmission, summed over all
/// bounces inside the sheet.
class ThinDielectricBxDF final : public BxDF {
  public:
    /// @param eta  index of the sheet over index around it, in [1e-3, 1e3]
    explicit ThinDielectricBxDF(float eta) : eta_(eta) {}

    Lobes Flags() const override { return Lobes::BothSides | Lobes::Specular; }
    /// Zero: both lobes are specular.
    BxDFValue Evaluate(Vec3, Vec3, const BxDFContext&) const override { return {}; }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    float eta_;
};

std::optional<BxDFSample> ThinDielectricBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                     const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    // Sum the geometric series R + T R T + T R^3 T + ... = 2R / (1 + R), with T = 1 - R.
    const float single = FresnelDielectric(AbsCosTheta(wo), eta_);
    const float reflectance = 2 * single / (1 + single), transmittance = 1 - reflectance;
    // Choose a side by energy.
    const float r = Any(context.sides, Lobes::Reflection) ? reflectance : 0.f;
    const float t = Any(context.sides, Lobes::Transmission) ? transmittance : 0.f;
    if (!(r + t > 0)) return std::nullopt;
    const float probability = r / (r + t);
    if (u.lobe < probability)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = SampledSpectrum(r + t),
                          .pdf = probability,
                          .pdfReverse = probability,
                          .lobe = Lobes::SpecularReflection};
    return BxDFSample{.wi = -wo,
                      .weight = SampledSpectrum(r + t),
                      .pdf = 1 - probability,
                      .pdfReverse = 1 - probability,
                      .lobe = Lobes::SpecularTransmission};
}

class ThinDielectricMaterial final : public Material {
  public:
    explicit ThinDielectricMaterial(IndexOfRefraction eta) : eta_(std::move(eta)) {}

    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<ThinDielectricBxDF>(eta_.At(lambda));
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override { return HasBump(); }

  private:
    IndexOfRefraction eta_;
};

std::unique_ptr<Material> CreateThinDielectric(const MaterialArgs& args) {
    auto material = std::make_unique<ThinDielectricMaterial>(IndexOfRefraction::Read(args.params));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "thindielectric", CreateThinDielectric);

}  // namespace lacquer
