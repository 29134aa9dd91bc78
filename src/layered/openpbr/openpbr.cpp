// Material "openpbr": OpenPBR Surface 1.1 as stacks of interfaces and slabs.
//
//   "float texture base_weight"                          1     scales base_color
//   "spectrum texture base_color"                        0.8   of what leaves; of metal, at normal incidence
//   "float texture base_diffuse_roughness"               0     of the diffuse base
//   "float texture base_metalness"                       0     part of the surface that is metal
//   "float texture specular_weight"                      1     scales reflectance at normal incidence
//   "spectrum texture specular_color"                    1     tint of reflection; of metal, at 82 degrees
//   "float texture specular_roughness"                   0.3   its square is the facets' alpha
//   "float texture specular_roughness_anisotropy"        0     1: along the tangent alone
//   "float texture specular_ior"                         1.5   index of the base
//   "float texture transmission_weight"                  0     part of the dielectric base that is clear
//   "spectrum texture transmission_color"                1     of light that passes twice
//   "float texture transmission_depth"                   0     above 0, a medium inside has the colour
//   "float texture transmission_dispersion_scale"        0     1: the index disperses by the Abbe number
//   "float texture transmission_dispersion_abbe_number"  20
//   "float texture subsurface_weight"                    0     part of the opaque base that scatters inside
//   "spectrum texture subsurface_color"                  0.8   what leaves of it
//   "float texture subsurface_scatter_anisotropy"        0     mean cosine of that
//   "float texture fuzz_weight"                          0     part of the surface that has fibres on it
//   "spectrum texture fuzz_color"                        1     albedo of the fibres
//   "float texture fuzz_roughness"                       0.5   0: all fibres stand upright
//   "float texture coat_weight"                          0     part of the surface that has a coat
//   "spectrum texture coat_color"                        1     of light that passes the coat twice
//   "float texture coat_roughness"                       0
//   "float texture coat_roughness_anisotropy"            0
//   "float texture coat_ior"                             1.6
//   "float texture thin_film_weight"                     0     part of the base that has a film on it
//   "float texture thin_film_thickness"                  0.5   in micrometers
//   "float texture thin_film_ior"                        1.4
//   "float texture geometry_opacity"                     1     part of the surface that is there
//   "bool geometry_thin_walled"                          false a sheet, with the same medium on both sides
//   "bool multiscatter"                                  true  light may meet several facets of an interface
//   "estimator", "pdf", "nsamples", and the parameters of these: as for "layered"
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include <fmt/format.h>

#include "layered/materials/stack_builder.h"
#include "layered/openpbr/openpbr_stack.h"
#include "pbrt/base/warnings.h"

namespace lacquer::layered {
namespace {

class OpenPBRMaterial;

/// One of the surfaces that the specification mixes. Its owner draws among them by their weights.
class OpenPBRPart final : public Material {
  public:
    OpenPBRPart(const OpenPBRMaterial& owner, OpenPBRVariant variant) : owner_(owner), variant_(variant) {}
    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override;
    bool NeedsFootprint() const override;

  private:
    const OpenPBRMaterial& owner_;
    OpenPBRVariant variant_;
};

class OpenPBRMaterial final : public Material, public NoStackBoundary, public HasWarnings {
  public:
    OpenPBRMaterial(const OpenPBRTextures& textures, LayeredSettings settings, bool isThinWalled,
                    bool rescatters, std::vector<Diagnostic> warnings)
        : textures_(textures),
          settings_(std::move(settings)),
          isThinWalled_(isThinWalled),
          rescatters_(rescatters),
          isConstant_(textures.IsConstant()),
          warnings_(std::move(warnings)) {
        for (int i = 0; i < OpenPBRVariant::kCount; ++i) parts_.emplace_back(*this, OpenPBRVariant::At(i));
    }

    const Material* Choose(const TextureContext& context, Vec3 wo) const override {
        return &parts_[size_t(Draw(context, Hash(context.p, wo)).Index())];
    }
    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return Choose(context, Vec3(0))->MakeBxDF(context, lambda, arena);
    }
    BxDF* MakeVariant(const OpenPBRVariant& variant, const TextureContext& context,
                      SampledWavelengths& lambda, Arena& arena) const {
        return MakeOpenPBR(variant, textures_.At(context, lambda), settings_.options, rescatters_, lambda,
                           arena);
    }
    bool NeedsFootprint() const override { return HasBump() || !isConstant_; }
    bool Transmits() const override { return isThinWalled_ || textures_.MayTransmit(); }
    std::string WhyNoStackBoundary() const override {
        return "is a stack itself; expected one interface: \"coat_weight\" and \"fuzz_weight\" put layers on "
               "it";
    }
    std::span<const Diagnostic> Warnings() const override { return warnings_; }

  private:
    /// The mixtures of the specification in their order, each by a number of its own.
    OpenPBRVariant Draw(const TextureContext& context, uint64_t hash) const {
        const OpenPBRTextures::Weights w = textures_.WeightsAt(context);
        int number = 0;
        const auto isDrawn = [&](float weight) { return UnitFloat(Hash(hash, ++number)) < weight; };
        OpenPBRVariant v;
        v.isThinWalled = isThinWalled_;
        v.isThere = isDrawn(w.opacity);
        if (!v.isThere) return v;
        v.hasFuzz = isDrawn(w.fuzz);
        v.hasCoat = isDrawn(w.coat);
        v.hasFilm = isDrawn(w.thinFilm);
        v.isMetal = isDrawn(w.metalness);
        v.transmits = !v.isMetal && isDrawn(w.transmission);
        v.hasSubsurface = !v.isMetal && !v.transmits && isDrawn(w.subsurface);
        return v;
    }

    OpenPBRTextures textures_;
    LayeredSettings settings_;
    bool isThinWalled_, rescatters_, isConstant_;
    std::vector<Diagnostic> warnings_;
    std::vector<OpenPBRPart> parts_;
};

BxDF* OpenPBRPart::MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const {
    return owner_.MakeVariant(variant_, context, lambda, arena);
}
bool OpenPBRPart::NeedsFootprint() const { return owner_.NeedsFootprint(); }

/// Parameters of the specification that have no effect here: what to do instead.
void WarnOfOthers(const Params& params, std::vector<Diagnostic>& warnings) {
    constexpr std::pair<const char*, const char*> kElsewhere[] = {
        {"emission_luminance", "surfaces emit by AreaLightSource before the shape"},
        {"emission_color", "surfaces emit by AreaLightSource before the shape"},
        {"transmission_scatter", "what scatters inside is a medium: MediumInterface before the shape"},
        {"transmission_scatter_anisotropy",
         "what scatters inside is a medium: MediumInterface before the shape"},
        {"subsurface_radius", "light leaves where it has entered; its colour does not depend on the radius"},
        {"subsurface_radius_scale",
         "light leaves where it has entered; its colour does not depend on the radius"},
        {"coat_darkening", "a coat darkens what lies below it by what it is"},
        {"geometry_normal", "\"normalmap\" or \"displacement\" of the material turn its normal"},
        {"geometry_coat_normal", "coat and base have one normal, that of \"normalmap\" or \"displacement\""},
        {"geometry_tangent", "\"rotation\" turns the tangent"},
        {"geometry_coat_tangent", "coat and base have one tangent, which \"rotation\" turns"},
    };
    for (const auto& [name, why] : kElsewhere) {
        if (!params.Has(name)) continue;
        warnings.push_back({Diagnostic::Severity::Warning, params.LocOf(name),
                            fmt::format("\"{}\" has no effect: {}", name, why)});
        for (const Parameter& p : params.All())
            if (p.name == name) params.Ignore(p.type, name);
    }
}

std::unique_ptr<Material> CreateOpenPBR(const MaterialArgs& args) {
    std::vector<Diagnostic> warnings;
    WarnOfOthers(args.params, warnings);
    const OpenPBRTextures textures = OpenPBRTextures::Read(args.params, args.textures);
    auto material = std::make_unique<OpenPBRMaterial>(
        textures, ReadLayeredSettings(args), args.params.GetBool("geometry_thin_walled", false),
        args.params.GetBool("multiscatter", true), std::move(warnings));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "openpbr", CreateOpenPBR, {.isLayered = true});

}  // namespace lacquer::layered
