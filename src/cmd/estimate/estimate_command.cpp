// Command "estimate": parameters of materials from photographs, with their uncertainty.
#include <fmt/format.h>

#include "cmd/command.h"
#include "cmd/estimate/estimate_job.h"
#include "cmd/estimate/layered_job.h"
#include "cmd/estimate/layered_problem.h"
#include "cmd/estimate/layered_synthetic.h"

namespace lacquer::cmd {
namespace {

ExitStatus RunEstimate(const EstimateArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    RefuseIneffective(a.json && !a.listModels, "--json",
                      "without --models: results are written to --out as JSON anyway");
    if (a.listModels) {
        fmt::print("{}", ModelTable(a.json, a.distance.value_or(estimate::kPriorDistance)));
        return ExitStatus::Complete;
    }
    if (!a.scene.empty()) {
        CheckLayeredArguments(a);
        if (!a.simulate.empty()) return SimulateLayers(a, &console);
        if (a.calibration > 0) return CalibrateLayers(a, &console);
        if (a.photo.empty())
            throw CLI::ValidationError("data are required: a goniometer's CSV or .bsdf, or a photograph");
        return EstimateLayers(a, &console);
    }
    CheckModelArguments(a);
    if (!a.simulate.empty()) return SimulatePhotograph(a, &console);
    if (a.calibration > 0) return CalibrateMethod(a, &console);
    if (a.photo.empty()) throw CLI::ValidationError("photo is required: an image file");
    return EstimateFromPhotograph(a, &console);
}

constexpr const char* kEstimateSynopsis =
    "Estimates the parameters of a procedural material from a flash photograph, or of a layered one from a\n"
    "goniometer's table, as a posterior distribution: what they are, and how well the data tell them.\n"
    "Usage: lacquer estimate [OPTIONS] photo.png --model MODEL --out DIR\n"
    "       lacquer estimate [OPTIONS] data.csv --scene scene.pbrt --free NAME.PARAMETER,... --out DIR";
constexpr const char* kEstimateFooter = R"(
Exit status: 0 everything is written; 1 wrong usage; 2 the photograph cannot be one; 3 a file cannot be read
or written; 4 everything is written, but the draws have not converged; 5 stopped by --time-limit, 129,
130 or 143 by a signal (DIR holds what was done, and --resume goes on with it).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "estimate",
                 (CommandOf<EstimateArguments, AddEstimateOptions, RunEstimate>::Make),
                 {.synopsis = kEstimateSynopsis, .footer = kEstimateFooter});

}  // namespace lacquer::cmd
