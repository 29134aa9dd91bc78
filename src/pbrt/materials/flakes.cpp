// Material "flakes": mirror flakes strewn in a clear binder, each one where it is: the effect pigments of car
// paint. Between them, and through pearls, light goes straight on. In a stack, its index is that above.
//
//   "string flake"           metal  "metal", or "pearl": clear plates, which pass on what they do not reflect
//   "spectrum texture eta", "spectrum texture k"  metal-Al-eta, metal-Al-k  index of refraction of metal
//   "spectrum texture reflectance"                -                         instead of them: the reflectance
//                                                                           at normal incidence
//   "float eta"              1.58   index of refraction of pearls
//   "float thinfilm_spread"  0      standard deviation of the films' thickness from flake to flake, over its
//                                   mean: colours that differ
//   "float size"             0.001  diameter of a flake in the plane of (uscale u, vscale v)
//   "float coverage"         0.5    share of the surface under flakes, which overlap by chance
//   "float density"          -      instead of it: flakes in a unit of that plane
//   "float uscale", "float vscale"  1
//   "integer seed"           0      another one is another sheet
//   "float flakeroughness"   0.02   what a flake itself spreads light by: largest slope of its surface
//   "bool discrete"          true   false: without end many flakes of no size, the mean of the others
//   "roughness", "uroughness", "vroughness", "remaproughness", "distribution": how the normals of flakes are
//                                   spread, by default a roughness of 0.02; see roughness.h
//   "thinfilm_thickness", "thinfilm_eta", "thinfilm_k": films on their faces, which on pearls do not absorb;
//                                   see thin_film_textures.h
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/flakes.h"

#include <fmt/format.h>

#include <cmath>

#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/materials/flake_layout.h"
#include "pbrt/materials/metal_textures.h"
#include "pbrt/materials/roughness.h"
#include "pbrt/materials/thin_film_textures.h"

namespace lacquer {
namespace {

/// Metal or plates, and the films on them.
struct FlakeOpticsTextures {
    std::optional<MetalTextures> metal;
    float plateEta = 1;
    ThinFilmTextures film;
    float spread = 0;

    static FlakeOpticsTextures Read(const Params& params, TextureLibrary& textures) {
        FlakeOpticsTextures optics;
        optics.film = ThinFilmTextures::Read(params, textures);
        optics.spread = params.GetFloatInRange("thinfilm_spread", 0, 0, 0.5f);
        if (optics.spread > 0) ThinFilmTextures::RequireThickness(params, "thinfilm_spread");
        if (params.GetChoice("flake", "metal", {"metal", "pearl"}) == "metal") {
            optics.metal = MetalTextures::Read(params, textures, "", "Al");
            return optics;
        }
        optics.plateEta = params.GetFloatInRange("eta", 1.58f, 1e-3f, 1e3f);
        for (const char* name : {"thinfilm_k", "k", "reflectance"})
            if (params.Has(name))
                params.Fail(name,
                            fmt::format("flakes of pearl are clear and have no \"{}\"; expected it only of "
                                        "\"string flake\" \"metal\"",
                                        name));
        return optics;
    }
    FlakeOptics At(const TextureContext& context, const SampledWavelengths& lambda, float etaAbove) const {
        const std::optional<ThinFilm> filmHere = film.At(context, lambda, etaAbove);
        if (!metal) return FlakeOptics::Plate(plateEta / etaAbove, filmHere, spread);
        const auto [eta, k] = metal->At(context, lambda, etaAbove);
        return FlakeOptics::Metal(eta, k, filmHere, spread);
    }
};

class FlakesMaterial final : public Material, public StackBoundary {
  public:
    FlakesMaterial(const FlakeLayout& layout, const FlakeOpticsTextures& optics,
                   const RoughnessTextures& roughness, float flakeRoughness, bool isDiscrete)
        : layout_(layout),
          optics_(optics),
          roughness_(roughness),
          flakeRoughness_(flakeRoughness),
          isDiscrete_(isDiscrete) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return Make(context, lambda, arena, 1, false);
    }
    BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                       const BoundaryMedia& media) const override {
        return Make(context, lambda, arena, media.etaAbove, true);
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override { return true; }

  private:
    BxDF* Make(const TextureContext& context, const SampledWavelengths& lambda, Arena& arena, float etaAbove,
               bool isInStack) const {
        const Alphas alphas = roughness_.At(context);
        const FlakeOptics optics = optics_.At(context, lambda, etaAbove);
        // Without a surface there is no place: what is measured of a material is that of no flake.
        if (!isDiscrete_ || !context.surface)
            return NewMicrofacetBxDF<FlakesBxDF>(roughness_.Model(), arena, alphas, flakeRoughness_, optics,
                                                 layout_.Coverage());
        FlakesInWindow flakes = layout_.WindowAt(context, MostFlakes(alphas));
        if (isInStack) flakes.sheetCoverage = layout_.Coverage();
        return NewMicrofacetBxDF<FlakesBxDF>(roughness_.Model(), arena, alphas, flakeRoughness_, optics,
                                             flakes);
    }
    /// So that an evaluation meets some fifty flakes whose normals are near, if those are spread evenly.
    float MostFlakes(Alphas alphas) const {
        constexpr float kMaxMet = 50, kMax = 1024;
        const float nearShare = std::min(Sqr(flakeRoughness_) / (alphas.x * alphas.y), 1.f);
        return std::min(kMaxMet / nearShare, kMax);
    }

    FlakeLayout layout_;
    FlakeOpticsTextures optics_;
    RoughnessTextures roughness_;
    float flakeRoughness_;
    bool isDiscrete_;
};

FlakeLayout ReadLayout(const Params& params) {
    constexpr float kSmallest = 1e-9f, kLargest = 1e9f, kMinCoverage = 1e-6f, kMaxCoverage = 0.999f;
    FlakeLayout layout;
    layout.seed = Hash(params.GetInt("seed", 0));
    layout.radius = 0.5f * params.GetFloatInRange("size", 0.001f, kSmallest, kLargest);
    layout.scale = {params.GetFloatInRange("uscale", 1, -kLargest, kLargest),
                    params.GetFloatInRange("vscale", 1, -kLargest, kLargest)};
    if (params.Has("density") && params.Has("coverage"))
        params.Fail("density",
                    "flakes have either a \"density\" or a \"coverage\"; expected only one of the two");
    const float coverage = params.GetFloatInRange("coverage", 0.5f, kMinCoverage, kMaxCoverage);
    const auto densityOf = [&](float share) { return -std::log1p(-share) / layout.AreaOfFlake(); };
    layout.density = params.Has("density") ? params.GetFloatInRange("density", 1, densityOf(kMinCoverage),
                                                                    densityOf(kMaxCoverage))
                                           : densityOf(coverage);
    return layout;
}

std::unique_ptr<Material> CreateFlakes(const MaterialArgs& args) {
    const Params& params = args.params;
    const FlakeLayout layout = ReadLayout(params);
    const FlakeOpticsTextures optics = FlakeOpticsTextures::Read(params, args.textures);
    const RoughnessTextures roughness = RoughnessTextures::Read(params, args.textures, "", 0.02f);
    auto material = std::make_unique<FlakesMaterial>(
        layout, optics, roughness, params.GetFloatInRange("flakeroughness", 0.02f, 1e-3f, 1),
        params.GetBool("discrete", true));
    material->ReadBump(params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "flakes", CreateFlakes);

}  // namespace lacquer
