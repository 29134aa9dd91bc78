// Material "subsurface": a dielectric boundary over a dense scattering medium, such as skin, milk or marble.
//
//   "string name"                                           -            a measured medium
//                                                                        (data/scattering/presets.txt), in
//                                                                        1/mm
//   "spectrum texture sigma_a", "spectrum texture sigma_s"  Wholemilk's  absorption and scattering
//                                                                        coefficient; both or neither
//   "spectrum texture reflectance"                          -            instead: the fraction of the light
//                                                                        let in that comes out again
//   "spectrum texture mfp"                                  1            with reflectance: mean free path
//   "float scale"                                           1            multiplies the coefficients, or the
//                                                                        mean free path
//   "float g"                                               0            mean cosine of scattering; 0 for a
//                                                                        named medium
//   "float eta"                                             1.33         index inside over index outside, 0.4
//                                                                        to 2.5
//   "roughness", "uroughness", "vroughness", "remaproughness", "distribution": see roughness.h
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
//
// The name takes precedence over the coefficients, and these over the reflectance. Lengths are in units of
// the scene.
#include <fmt/format.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/tabulated_bssrdf.h"
#include "pbrt/materials/roughness.h"
#include "pbrt/scattering/presets.h"

namespace lacquer {
namespace {

/// Lengths and their inverses in the medium stay within these, so that their squares are finite.
constexpr float kMaxSigma = 1e15f, kMinMfp = 1e-12f;

/// What the medium is made of: coefficients, or what they are found from. Pointers of the other form are
/// null.
struct MediumTextures {
    const SpectrumTexture* sigma_a = nullptr;
    const SpectrumTexture* sigma_s = nullptr;
    const SpectrumTexture* reflectance = nullptr;
    const SpectrumTexture* mfp = nullptr;
    bool isNamed = false;

    static MediumTextures Read(const Params& params, TextureLibrary& textures);
    bool IsConstant() const {
        return reflectance ? reflectance->IsConstant() && mfp->IsConstant()
                           : sigma_a->IsConstant() && sigma_s->IsConstant();
    }
};

const SpectrumTexture* UnboundedRgb(RGB rgb, TextureLibrary& textures) {
    return textures.Own(std::make_unique<SpectrumConstantTexture>(
        ColorSpace::SRGB().MakeSpectrum(rgb, SpectrumKind::Unbounded)));
}

MediumTextures Preset(const std::string& name, TextureLibrary& textures) {
    const ScatteringPreset preset = *FindScatteringPreset(name);
    MediumTextures medium;
    medium.sigma_a = UnboundedRgb(preset.sigma_a, textures);
    medium.sigma_s = UnboundedRgb(preset.reducedSigma_s, textures);
    return medium;
}

MediumTextures MediumTextures::Read(const Params& params, TextureLibrary& textures) {
    if (const std::string name = params.GetString("name", ""); !name.empty()) {
        if (!FindScatteringPreset(name))
            params.Fail("name", fmt::format("unknown preset \"{}\" of a scattering medium{}", Excerpt(name),
                                            DidYouMean(name, ScatteringPresetNames())));
        MediumTextures medium = Preset(name, textures);
        medium.isNamed = true;
        return medium;
    }
    MediumTextures medium;
    medium.sigma_a = OptionalSpectrumTextureParam(params, "sigma_a", SpectrumKind::Unbounded, textures);
    medium.sigma_s = OptionalSpectrumTextureParam(params, "sigma_s", SpectrumKind::Unbounded, textures);
    if (!medium.sigma_a != !medium.sigma_s) {
        const char* const given = medium.sigma_a ? "sigma_a" : "sigma_s";
        params.Fail(given, fmt::format("\"{}\" is given without \"{}\"; expected both or neither", given,
                                       medium.sigma_a ? "sigma_s" : "sigma_a"));
    }
    if (medium.sigma_a) return medium;
    medium.reflectance = OptionalSpectrumTextureParam(params, "reflectance", SpectrumKind::Albedo, textures);
    if (!medium.reflectance) return Preset("Wholemilk", textures);
    medium.mfp = SpectrumTextureParam(params, "mfp", SpectrumKind::Unbounded, 1, textures);
    return medium;
}

class SubsurfaceMaterial final : public Material, public NoStackBoundary {
  public:
    SubsurfaceMaterial(const MediumTextures& medium, float scale, float g, float eta,
                       const RoughnessTextures& roughness)
        : medium_(medium),
          scale_(scale),
          eta_(eta),
          roughness_(roughness),
          table_(BssrdfTable::Shared(g, eta)) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths&, Arena& arena) const override {
        return NewMicrofacetBxDF<DielectricBxDF>(roughness_.Model(), arena, roughness_.At(context), eta_);
    }
    BSSRDF* MakeBSSRDF(const TextureContext& context, const SampledWavelengths& lambda,
                       Arena& arena) const override {
        SampledSpectrum sigma_a, sigma_s;
        if (medium_.reflectance) {
            const SampledSpectrum share = Clamp(medium_.reflectance->Evaluate(context, lambda), 0, 1);
            const SampledSpectrum mfp =
                Max(medium_.mfp->Evaluate(context, lambda) * scale_, SampledSpectrum(kMinMfp));
            const SampledSpectrum albedo =
                Map(share, [this](float s) { return table_->InvertEffectiveAlbedo(s); });
            sigma_s = albedo / mfp;
            sigma_a = (1 - albedo) / mfp;
        } else {
            sigma_a = Clamp(medium_.sigma_a->Evaluate(context, lambda) * scale_, 0, kMaxSigma);
            sigma_s = Clamp(medium_.sigma_s->Evaluate(context, lambda) * scale_, 0, kMaxSigma);
        }
        return arena.New<TabulatedBSSRDF>(context.p, context.n, eta_, sigma_a, sigma_s, *table_);
    }
    bool HasSubsurface() const override { return true; }
    std::string WhyNoStackBoundary() const override {
        return "scatters light below its surface; expected a material that is a surface alone";
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override {
        return HasBump() || !medium_.IsConstant() || !roughness_.IsConstant();
    }

  private:
    MediumTextures medium_;
    float scale_, eta_;
    RoughnessTextures roughness_;
    std::shared_ptr<const BssrdfTable> table_;
};

std::unique_ptr<Material> CreateSubsurface(const MaterialArgs& args) {
    const Params& params = args.params;
    const MediumTextures medium = MediumTextures::Read(params, args.textures);
    const float scale = params.GetFloatInRange("scale", 1, 0, 1e12f);
    const float g = params.GetFloatInRange("g", 0, -1, 1);
    // Beyond these, the polynomials of Fresnel's moments mean nothing.
    const float eta = params.GetFloatInRange("eta", 1.33f, 0.4f, 2.5f);
    // What was measured is reduced scattering, which is isotropic.
    auto material = std::make_unique<SubsurfaceMaterial>(medium, scale, medium.isNamed ? 0 : g, eta,
                                                         RoughnessTextures::Read(params, args.textures));
    material->ReadBump(params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "subsurface", CreateSubsurface);

}  // namespace lacquer
