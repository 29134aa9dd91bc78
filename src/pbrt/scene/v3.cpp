#include "pbrt/scene/v3.h"

#include <fmt/format.h>

#include "pbrt/core/parameter.h"

namespace lacquer {

namespace {

struct Rule {
    const char *directive, *name, *advice;
};

constexpr Rule kPlugins[] = {
    {"Film", "image", "it is \"rgb\""},
    {"Sampler", "lowdiscrepancy", "it is \"paddedsobol\""},
    {"Sampler", "02sequence", "it is \"paddedsobol\""},
    {"Sampler", "maxmindist", "it is \"pmj02bn\""},
    {"Sampler", "random", "it is \"independent\""},
    {"Integrator", "directlighting", "it is \"path\" with \"integer maxdepth\" 1"},
    {"Integrator", "whitted", "\"path\" takes its place"},
    {"Camera", "environment", "it is \"spherical\" with \"string mapping\" \"equirectangular\""},
    {"Medium", "heterogeneous", "it is \"uniformgrid\""},
    {"Material", "matte", "it is \"diffuse\""},
    {"Material", "plastic", "it is \"coateddiffuse\""},
    {"Material", "uber", "it is \"coateddiffuse\""},
    {"Material", "substrate", "it is \"coateddiffuse\""},
    {"Material", "glass", "it is \"dielectric\""},
    {"Material", "metal", "it is \"conductor\""},
    {"Material", "mirror", "it is \"conductor\""},
    {"Material", "translucent", "it is \"diffusetransmission\""},
    {"Material", "kdsubsurface", "it is \"subsurface\""},
    {"Material", "disney", "\"diffuse\" takes its place"},
    {"Material", "fourier", "there is no such material; \"measured\" is the nearest"},
    {"AreaLightSource", "area", "it is \"diffuse\""},
    {"Shape", "cone", "there is no such shape; use a mesh"},
    {"Shape", "hyperboloid", "there is no such shape; use a mesh"},
    {"Shape", "paraboloid", "there is no such shape; use a mesh"},
    {"Shape", "heightfield", "there is no such shape; use a mesh"},
    {"Shape", "nurbs", "there is no such shape; use a mesh"},
};

/// `plugin` null: any plugin of the directive; `type` null: any type.
struct ParameterRule {
    const char *directive, *plugin, *type, *name, *advice;
};

constexpr ParameterRule kParameters[] = {
    {"PixelFilter", nullptr, "float", "xwidth", "it is \"float xradius\""},
    {"PixelFilter", nullptr, "float", "ywidth", "it is \"float yradius\""},
    {"PixelFilter", "gaussian", "float", "alpha", "it is \"float sigma\", 1/sqrt(2 alpha)"},
    {"Film", nullptr, "float", "maxsampleluminance", "it is \"float maxcomponentvalue\""},
    {"Film", nullptr, "float", "scale", "it is \"float iso\", 100 times the scale"},
    {"Integrator", nullptr, "float", "rrthreshold", "there is no such parameter: remove it"},
    {"Integrator", nullptr, "string", "lightsamplestrategy",
     "it is \"string lightsampler\", \"bvh\" for \"spatial\""},
    {"Integrator", "sppm", "integer", "imagewritefrequency", "there is no such parameter: remove it"},
    {"Integrator", "sppm", "integer", "numiterations", "there is no such parameter: remove it"},
    {"Camera", "realistic", "bool", "simpleweighting", "there is no such parameter: remove it"},
    {"Material", nullptr, nullptr, "Kd", "it is \"reflectance\""},
    {"Material", nullptr, nullptr, "Kr", "it is \"reflectance\""},
    {"Material", nullptr, nullptr, "Kt", "it is \"transmittance\""},
    {"Material", nullptr, nullptr, "Ks", "there is no such parameter: remove it"},
    {"Material", nullptr, nullptr, "index", "it is \"eta\""},
    {"Material", nullptr, nullptr, "bumpmap", "it is \"displacement\""},
    {"Texture", "scale", nullptr, "tex1", "it is \"tex\""},
    {"Texture", "scale", nullptr, "tex2", "it is \"float scale\" or \"texture scale\""},
    {"Texture", "imagemap", "bool", "trilinear", "it is \"string filter\" \"trilinear\""},
    {"Texture", "imagemap", "bool", "gamma", "it is \"string encoding\", \"sRGB\" or \"linear\""},
    {"Texture", "imagemap", "float", "gamma", "it is \"string encoding\", \"gamma\" and the number"},
    {"LightSource", nullptr, "string", "mapname", "it is \"string filename\""},
    {"LightSource", nullptr, "rgb", "scale", "it is \"float scale\""},
    {"LightSource", nullptr, "integer", "samples", "there is no such parameter: remove it"},
    {"LightSource", nullptr, "integer", "nsamples", "there is no such parameter: remove it"},
    {"AreaLightSource", nullptr, "rgb", "scale", "it is \"float scale\""},
    {"AreaLightSource", nullptr, "integer", "samples", "there is no such parameter: remove it"},
    {"AreaLightSource", nullptr, "integer", "nsamples", "there is no such parameter: remove it"},
    {"Shape", nullptr, nullptr, "st", "it is \"point2 uv\""},
    {"Shape", nullptr, "float", "uv", "it is \"point2 uv\""},
    {"Shape", nullptr, "integer", "nlevels", "it is \"integer levels\""},
    {"Shape", nullptr, nullptr, "shadowalpha", "there is no such parameter: remove it"},
    {"Shape", nullptr, "bool", "discarddegenerateUVs", "there is no such parameter: remove it"},
};

template <size_t N>
std::optional<std::string> Find(const Rule (&rules)[N], std::string_view directive, std::string_view name) {
    for (const Rule& rule : rules)
        if (directive == rule.directive && name == rule.name) return rule.advice;
    return std::nullopt;
}

}  // namespace

std::optional<std::string> V3Plugin(std::string_view directive, std::string_view type) {
    return Find(kPlugins, directive, type);
}

std::optional<std::string> V3ParameterType(std::string_view type) {
    if (const ParameterType* found = FindV3ParameterType(type))
        return fmt::format("it is \"{}\"", found->name);
    if (type == "xyz") return "there is no such type; use \"rgb\"";
    return std::nullopt;
}

std::optional<std::string> V3Parameter(std::string_view directive, std::string_view plugin,
                                       std::string_view type, std::string_view name) {
    for (const ParameterRule& rule : kParameters)
        if (directive == rule.directive && name == rule.name && (!rule.plugin || plugin == rule.plugin) &&
            (!rule.type || type == rule.type))
            return rule.advice;
    return std::nullopt;
}

std::optional<std::string> V3TextureType(std::string_view type) {
    if (type == "color") return "it is \"spectrum\"";
    return std::nullopt;
}

}  // namespace lacquer
