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
//   "float emission_luminance"                           0     of the light that a shape becomes [cd/m^2]
//   "spectrum emission_color"                            1     of that, of any magnitude
//   "string coat_normalmap"                              -     the coat's own, in place of "normalmap"
//   "float texture coat_rotation"                        -     of its tangent, likewise [degrees]
//   "bool multiscatter"                                  true  light may meet several facets of an interface
//   "estimator", "pdf", "nsamples", and the parameters of these: as for "layered"
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include <fmt/format.h>

#include "layered/materials/stack_builder.h"
#include "layered/openpbr/openpbr_emission.h"
#include "layered/openpbr/openpbr_stack.h"
#include "pbrt/base/emitting_material.h"
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

/// A frame that `normalmap` and others turn, and nothing else of a material.
class FrameOnly final : public Material {
  public:
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
};

/// What is known before a point is.
struct OpenPBRSettings {
    LayeredSettings layered;
    bool isThinWalled = false, rescatters = true;
    /// Frames of the coat and of what lies below it, where the coat has one of its own; else null, and
    /// Material::Bump() turns the whole stack.
    std::unique_ptr<Material> coatFrame, baseFrame;
    std::optional<Params> emission;
    std::vector<Diagnostic> warnings;
};

class OpenPBRMaterial final : public Material,
                              public NoStackBoundary,
                              public EmittingMaterial,
                              public HasWarnings {
  public:
    OpenPBRMaterial(const OpenPBRTextures& textures, OpenPBRSettings settings)
        : textures_(textures), settings_(std::move(settings)), isConstant_(textures.IsConstant()) {
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
        OpenPBRFrames frames;
        if (settings_.coatFrame)
            frames = {true, settings_.coatFrame->BumpedFrame(context),
                      settings_.baseFrame->BumpedFrame(context)};
        return MakeOpenPBR(variant, textures_.At(context, lambda), frames, settings_.layered.options,
                           settings_.rescatters, lambda, arena);
    }
    bool NeedsFootprint() const override { return HasBump() || settings_.coatFrame || !isConstant_; }
    bool Transmits() const override { return settings_.isThinWalled || textures_.MayTransmit(); }
    const Params* EmissionParams() const override {
        return settings_.emission ? &*settings_.emission : nullptr;
    }
    std::string WhyNoStackBoundary() const override {
        return "is a stack itself; expected one interface: \"coat_weight\" and \"fuzz_weight\" put layers on "
               "it";
    }
    std::span<const Diagnostic> Warnings() const override { return settings_.warnings; }

  private:
    /// The mixtures of the specification in their order, each by a number of its own.
    OpenPBRVariant Draw(const TextureContext& context, uint64_t hash) const {
        const OpenPBRTextures::Weights w = textures_.WeightsAt(context);
        int number = 0;
        const auto isDrawn = [&](float weight) { return UnitFloat(Hash(hash, ++number)) < weight; };
        OpenPBRVariant v;
        v.isThinWalled = settings_.isThinWalled;
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
    OpenPBRSettings settings_;
    bool isConstant_;
    std::vector<OpenPBRPart> parts_;
};

BxDF* OpenPBRPart::MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const {
    return owner_.MakeVariant(variant_, context, lambda, arena);
}
bool OpenPBRPart::NeedsFootprint() const { return owner_.NeedsFootprint(); }

/// Parameters of the specification that have no effect here: what to do instead.
void WarnOfOthers(const Params& params, std::vector<Diagnostic>& warnings) {
    constexpr std::pair<const char*, const char*> kElsewhere[] = {
        {"transmission_scatter", "what scatters inside is a medium: MediumInterface before the shape"},
        {"transmission_scatter_anisotropy",
         "what scatters inside is a medium: MediumInterface before the shape"},
        {"subsurface_radius", "light leaves where it has entered; its colour does not depend on the radius"},
        {"subsurface_radius_scale",
         "light leaves where it has entered; its colour does not depend on the radius"},
        {"coat_darkening", "a coat darkens what lies below it by what it is"},
        {"geometry_normal", "\"normalmap\" or \"displacement\" of the material turn its normal"},
        {"geometry_coat_normal", "\"coat_normalmap\" turns the normal of the coat"},
        {"geometry_tangent", "\"rotation\" turns the tangent"},
        {"geometry_coat_tangent", "\"coat_rotation\" turns the tangent of the coat"},
    };
    for (const auto& [name, why] : kElsewhere) {
        if (!params.Has(name)) continue;
        warnings.push_back({Diagnostic::Severity::Warning, params.LocOf(name),
                            fmt::format("\"{}\" has no effect: {}", name, why)});
        for (const Parameter& p : params.All())
            if (p.name == name) params.Ignore(p.type, name);
    }
}

/// The frame of the coat by `coat_normalmap` and `coat_rotation`; null without them. Material::ReadBump()
/// knows these by the names that they have for a whole material.
std::unique_ptr<Material> ReadCoatFrame(const Params& params, TextureLibrary& textures) {
    constexpr std::pair<const char*, const char*> kNames[] = {{"coat_normalmap", "normalmap"},
                                                              {"coat_rotation", "rotation"}};
    // These ask for the types that there are, so that others are reported.
    const bool hasMap = params.GetOptionalString("coat_normalmap").has_value();
    if (!hasMap && !OptionalFloatTextureParam(params, "coat_rotation", textures)) return nullptr;
    std::vector<Parameter> own;
    for (const Parameter& p : params.All())
        for (const auto& [name, general] : kNames)
            if (p.name == name) {
                own.push_back(p);
                own.back().name = general;
                if (p.type == "string") own.back().strings = {params.PathOf(name)};
            }
    auto frame = std::make_unique<FrameOnly>();
    frame->ReadBump({"coat of material \"openpbr\"", params.Loc(), std::move(own), &params.ColorSpace()},
                    textures);
    return frame;
}

/// Neither a coat nor fuzz lies on what emits here, and it has no holes.
void WarnOfHiddenEmission(const Params& params, const OpenPBRTextures& textures,
                          std::vector<Diagnostic>& warnings) {
    if (textures.HasCoatOrFuzz())
        warnings.push_back({Diagnostic::Severity::Warning, params.LocOf("emission_luminance"),
                            "emission leaves the surface as if no coat and no fuzz lay on it"});
    if (!textures.ConstantOpacity())
        warnings.push_back({Diagnostic::Severity::Warning, params.LocOf("emission_luminance"),
                            "emission leaves also where the texture of \"geometry_opacity\" leaves a hole; "
                            "an \"alpha\" of the shape makes holes in both"});
}

std::unique_ptr<Material> CreateOpenPBR(const MaterialArgs& args) {
    OpenPBRSettings settings;
    WarnOfOthers(args.params, settings.warnings);
    const OpenPBRTextures textures = OpenPBRTextures::Read(args.params, args.textures);
    settings.layered = ReadLayeredSettings(args);
    settings.isThinWalled = args.params.GetBool("geometry_thin_walled", false);
    settings.rescatters = args.params.GetBool("multiscatter", true);
    settings.emission = ReadOpenPBREmission(args.params, textures.ConstantOpacity().value_or(1.f),
                                            settings.isThinWalled, settings.warnings);
    if (settings.emission) WarnOfHiddenEmission(args.params, textures, settings.warnings);
    settings.coatFrame = ReadCoatFrame(args.params, args.textures);
    if (settings.coatFrame) {
        settings.baseFrame = std::make_unique<FrameOnly>();
        settings.baseFrame->ReadBump(args.params, args.textures);
        return std::make_unique<OpenPBRMaterial>(textures, std::move(settings));
    }
    auto material = std::make_unique<OpenPBRMaterial>(textures, std::move(settings));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "openpbr", CreateOpenPBR, {.isLayered = true});

}  // namespace lacquer::layered
