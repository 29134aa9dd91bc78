#include "pbrt/phases/phase_params.h"

#include <fmt/format.h>

#include "pbrt/phases/bulk.h"

namespace lacquer {
namespace {

bool Has(const PhasePlugin& plugin, std::string_view parameter) {
    return std::find(plugin.parameters.begin(), plugin.parameters.end(), parameter) !=
           plugin.parameters.end();
}

/// A parameter of another phase function is no misspelling: the message says where it belongs.
void RefuseOthersParameters(const Params& params, const std::string& chosen) {
    const PhasePlugin& plugin = *Registry<PhaseKind>::Find(chosen);
    for (const Parameter& p : params.All()) {
        if (p.fromAttribute || Has(plugin, p.name)) continue;
        for (const std::string& other : Registry<PhaseKind>::Names())
            if (Has(*Registry<PhaseKind>::Find(other), p.name))
                throw SceneError(p.loc, fmt::format("\"{}\" has no effect on the phase function \"{}\"; it "
                                                    "belongs to \"string phase\" \"{}\"",
                                                    p.name, chosen, other));
    }
}

}  // namespace

std::unique_ptr<PhaseModel> ReadPhaseModel(const PhaseArgs& args, std::string_view fallback) {
    if (args.params.Has("bulk")) fallback = "bulk";
    const std::string name = args.params.GetChoice("phase", fallback, Registry<PhaseKind>::Names());
    RefuseBesideBulk(args.params);
    RefuseOthersParameters(args.params, name);
    return Registry<PhaseKind>::Find(name)->create(args);
}

void RefuseTexture(const PhaseArgs& args, std::string_view name) {
    if (args.params.GetTextureName(name))
        args.params.Fail(name, fmt::format("\"{0}\" is a texture, and a {1} has none; expected \"float {0}\"",
                                           name, args.owner.Kind()));
}

PhaseNumber ReadPhaseNumber(const PhaseArgs& args, std::string_view name, float fallback, float low,
                            float high) {
    TextureLibrary* textures = args.owner.Textures();
    if (!textures) RefuseTexture(args, name);
    const PhaseNumber number = textures
                                   ? PhaseNumber(FloatTextureParam(args.params, name, fallback, *textures))
                                   : PhaseNumber(args.params.GetFloat(name, fallback));
    const float value = number.Constant().value_or(fallback);
    if (value >= low && value <= high) return number;
    if (std::isinf(high))
        args.params.Fail(name,
                         fmt::format("\"{}\" is {}; expected a value of at least {}", name, value, low));
    args.params.Fail(name, fmt::format("\"{}\" is {}; expected a value in [{}, {}]", name, value, low, high));
}

}  // namespace lacquer
