// Integrator "function": "volpath" takes its place with a warning, since it converges to the same image.
// "integer maxdepth" and "bool regularize" keep their meaning; the others have no effect:
//
//   "function": "string function", "string filename", "bool skipbad", "string imagefilename"
#include "pbrt/integrators/substitutes.h"

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

std::unique_ptr<Integrator> SubstituteFunction(const IntegratorArgs& args) {
    for (const char* name : {"function", "filename", "imagefilename"}) args.params.Ignore("string", name);
    args.params.Ignore("bool", "skipbad");
    return VolPathInstead(args, "integrator \"function\" is not in Lacquer");
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "function", SubstituteFunction, {.otherImage = "is not in Lacquer"});

}  // namespace lacquer
