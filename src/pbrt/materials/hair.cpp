// Material "hair": fibres, for curves. The absorption is that of the first of these that are given:
//
//   "spectrum texture sigma_a"                                -       absorption in units of the inverse
//                                                                     radius
//   "spectrum texture reflectance", "spectrum texture color"  -       colour of many fibres together
//   "float texture eumelanin", "float texture pheomelanin"    1.3, 0  concentrations; 0 for the one not given
//
// Further parameters:
//   "float texture eta"                             1.55      index of refraction
//   "float texture beta_m", "float texture beta_n"  0.3, 0.3  longitudinal and azimuthal roughness, in [0.01,
//                                                             1]
//   "float texture alpha"                           2         tilt of the scales [degrees]
//   "string normalmap"                              -         has no effect
#include "pbrt/bxdfs/hair.h"
#include "pbrt/base/constant_texture.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"

namespace lacquer {
namespace {

class HairMaterial final : public Material, public NoStackBoundary {
  public:
    /// One of sigma_a, reflectance, and the two concentrations is there, the others are null.
    struct Textures {
        const SpectrumTexture* sigma_a = nullptr;
        const SpectrumTexture* reflectance = nullptr;
        const FloatTexture* eumelanin = nullptr;
        const FloatTexture* pheomelanin = nullptr;
        const FloatTexture* eta = nullptr;
        const FloatTexture* beta_m = nullptr;
        const FloatTexture* beta_n = nullptr;
        const FloatTexture* alpha = nullptr;
    };
    explicit HairMaterial(const Textures& textures) : t_(textures) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        HairBxDF::Parameters p;
        // Across a curve, v runs over its width.
        p.h = std::clamp(2 * context.uv.y - 1, -1.f, 1.f);
        p.eta = std::clamp(t_.eta->Evaluate(context), 1e-3f, 1e3f);
        p.beta_m = std::clamp(t_.beta_m->Evaluate(context), 0.01f, 1.f);
        p.beta_n = std::clamp(t_.beta_n->Evaluate(context), 0.01f, 1.f);
        p.alpha = Radians(t_.alpha->Evaluate(context));
        p.sigma_a = Clamp(SigmaA(context, lambda, p.beta_n), 0, 1e6f);
        return arena.New<HairBxDF>(p);
    }
    bool Transmits() const override { return true; }
    std::string WhyNoStackBoundary() const override {
        return "scatters around a fibre; expected the material of a surface";
    }
    bool NeedsFootprint() const override {
        for (const SpectrumTexture* texture : {t_.sigma_a, t_.reflectance})
            if (texture && !texture->IsConstant()) return true;
        for (const FloatTexture* texture :
             {t_.eumelanin, t_.pheomelanin, t_.eta, t_.beta_m, t_.beta_n, t_.alpha})
            if (texture && !texture->Constant()) return true;
        return false;
    }

  private:
    SampledSpectrum SigmaA(const TextureContext& context, const SampledWavelengths& lambda,
                           float beta_n) const {
        if (t_.sigma_a) return t_.sigma_a->Evaluate(context, lambda);
        if (t_.reflectance)
            return HairBxDF::SigmaAFromReflectance(Clamp(t_.reflectance->Evaluate(context, lambda), 0, 1),
                                                   beta_n);
        const auto concentration = [&](const FloatTexture* texture) {
            return texture ? std::clamp(texture->Evaluate(context), 0.f, 1e6f) : 0.f;
        };
        const RGB rgb =
            HairBxDF::SigmaAFromMelanin(concentration(t_.eumelanin), concentration(t_.pheomelanin));
        return SampleRGB(ColorSpace::SRGB(), rgb, SpectrumKind::Unbounded, lambda);
    }

    Textures t_;
};

std::unique_ptr<Material> CreateHair(const MaterialArgs& args) {
    const auto spectrum = [&](const char* name, SpectrumKind kind) {
        return OptionalSpectrumTextureParam(args.params, name, kind, args.textures);
    };
    const auto pigment = [&](const char* name) {
        return OptionalFloatTextureParam(args.params, name, args.textures);
    };
    const auto number = [&](const char* name, float fallback) {
        return FloatTextureParam(args.params, name, fallback, args.textures);
    };
    // All are read, so that what gives way is not taken for a mistake.
    HairMaterial::Textures t;
    t.sigma_a = spectrum("sigma_a", SpectrumKind::Unbounded);
    t.reflectance = spectrum("reflectance", SpectrumKind::Albedo);
    const SpectrumTexture* color = spectrum("color", SpectrumKind::Albedo);
    if (!t.reflectance) t.reflectance = color;
    t.eumelanin = pigment("eumelanin");
    t.pheomelanin = pigment("pheomelanin");
    if (t.sigma_a) t.reflectance = nullptr;
    if (t.sigma_a || t.reflectance)
        t.eumelanin = t.pheomelanin = nullptr;
    else if (!t.eumelanin && !t.pheomelanin)
        t.eumelanin = args.textures.Own(std::make_unique<FloatConstantTexture>(1.3f));

    t.eta = number("eta", 1.55f);
    t.beta_m = number("beta_m", 0.3f);
    t.beta_n = number("beta_n", 0.3f);
    t.alpha = number("alpha", 2);
    // The format allows it on every material; fibres have no use for it.
    args.params.Ignore("string", "normalmap");
    return std::make_unique<HairMaterial>(t);
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "hair", CreateHair);

}  // namespace lacquer
