#include "layered/openpbr/openpbr_emission.h"

#include <fmt/format.h>

#include <algorithm>

namespace lacquer::layered {
namespace {

/// The sun has 1.6e9.
constexpr float kMaxLuminance = 1e10f;

/// True if some texture is given where the light takes none.
bool HasTextures(const Params& params, std::vector<Diagnostic>& warnings) {
    bool hasTextures = false;
    for (const char* name : {"emission_luminance", "emission_color"}) {
        const bool isGiven = std::ranges::any_of(
            params.All(), [&](const Parameter& p) { return p.type == "texture" && p.name == name; });
        if (!isGiven) continue;
        // Not asked for by its type, which messages of other types would then recommend.
        params.Ignore("texture", name);
        hasTextures = true;
        warnings.push_back({Diagnostic::Severity::Warning, params.LocOf(name),
                            fmt::format("\"texture {}\" has no effect: surfaces emit the same everywhere; an "
                                        "AreaLightSource before the shape takes an image, \"filename\"",
                                        name)});
    }
    return hasTextures;
}

Parameter FloatParameter(const char* name, float value) {
    Parameter p;
    p.type = "float";
    p.name = name;
    p.floats = {value};
    return p;
}

}  // namespace

std::optional<Params> ReadOpenPBREmission(const Params& params, float opacity, bool isThin,
                                          std::vector<Diagnostic>& warnings) {
    const bool hasTextures = HasTextures(params, warnings);
    const float luminance = params.GetFloatInRange("emission_luminance", 0, 0, kMaxLuminance);
    // Checks the colour, and says that it was read.
    const bool hasColor = params.GetSpectrum("emission_color", SpectrumKind::Illuminant) != nullptr;
    if (hasTextures || !(luminance * opacity > 0)) return {};

    std::vector<Parameter> light{FloatParameter("scale", luminance * opacity)};
    for (const Parameter& p : params.All())
        if (hasColor && p.name == "emission_color") {
            light.push_back(p);
            light.back().name = "L";
        }
    if (isThin) {
        Parameter twoSided;
        twoSided.type = "bool";
        twoSided.name = "twosided";
        twoSided.kind = Parameter::Values::Bools;
        twoSided.bools = {1};
        light.push_back(twoSided);
    }
    return Params("emission of material \"openpbr\"", params.Loc(), std::move(light), &params.ColorSpace());
}

}  // namespace lacquer::layered
