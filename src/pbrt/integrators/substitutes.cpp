// Integrators "sppm" and "function": "volpath" takes their place with a warning, since it converges to
// the same image. "integer maxdepth" and "bool regularize" keep their meaning; the others have no effect:
//
//   "sppm": "integer photonsperiteration", "float radius", "integer seed"
//   "function": "string function", "string filename", "bool skipbad", "string imagefilename"
#include "pbrt/integrators/substitutes.h"

#include <fmt/format.h>

#include <span>

#include "pbrt/core/error.h"
#include "pbrt/core/params.h"
#include "pbrt/core/progress.h"

namespace lacquer {

std::unique_ptr<Integrator> VolPathInstead(const IntegratorArgs& args, const std::string& why) {
    if (!args.mayBeReplaced) throw SceneError(args.params.Loc(), why);
    const std::string message = why + "; \"volpath\" renders the scene instead";
    if (args.observer)
        args.observer->Warn(
            Diagnostic{Diagnostic::Severity::Warning, args.params.Loc(), message, {}}.ToString());
    return Registry<IntegratorKind>::Find("volpath")(args);
}

namespace {

struct IgnoredParameter {
    const char *type, *name;
};

std::unique_ptr<Integrator> Substitute(const IntegratorArgs& args, const char* name,
                                       std::span<const IgnoredParameter> ignored) {
    for (const IgnoredParameter& p : ignored) args.params.Ignore(p.type, p.name);
    return VolPathInstead(args, fmt::format("integrator \"{}\" is not in Lacquer", name));
}

std::unique_ptr<Integrator> SubstituteSppm(const IntegratorArgs& args) {
    static constexpr IgnoredParameter kIgnored[] = {
        {"integer", "photonsperiteration"}, {"float", "radius"}, {"integer", "seed"}};
    return Substitute(args, "sppm", kIgnored);
}
std::unique_ptr<Integrator> SubstituteFunction(const IntegratorArgs& args) {
    static constexpr IgnoredParameter kIgnored[] = {
        {"string", "function"}, {"string", "filename"}, {"bool", "skipbad"}, {"string", "imagefilename"}};
    return Substitute(args, "function", kIgnored);
}

}  // namespace

constexpr IntegratorKind::Traits kSubstituted{.otherImage = "is not in Lacquer"};
LACQUER_REGISTER(IntegratorKind, "sppm", SubstituteSppm, kSubstituted);
LACQUER_REGISTER(IntegratorKind, "function", SubstituteFunction, kSubstituted);

}  // namespace lacquer
