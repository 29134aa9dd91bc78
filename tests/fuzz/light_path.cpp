// Light path expressions of auxiliary outputs, and dates of skies: small languages of one line.
#include "fuzz/fuzz_target.h"
#include "pbrt/core/error.h"
#include "pbrt/film/light_path_automaton.h"
#include "pbrt/scattering/sun_position.h"

namespace lacquer::fuzz {
namespace {

void LightPath(std::string_view bytes) {
    const std::string text(bytes);
    ParseInstant(text);
    try {
        CheckLightPathExpression(text);
        const LightPathAutomaton automaton({text, "CD.*"}, {"", "key"});
        automaton.PassesOf(automaton.Next(LightPathAutomaton::kStart, PathEvent::DiffuseReflection),
                           PathSource::Light, 1);
    } catch (const LightPathError& e) {
        throw FileError("expression", e.what());
    }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "light_path", LightPath);

}  // namespace lacquer::fuzz
