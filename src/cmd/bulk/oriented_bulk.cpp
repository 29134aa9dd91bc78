#include "cmd/bulk/oriented_bulk.h"

#include <fmt/format.h>
#include <signal.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "bulk/table/oriented_computation.h"
#include "cmd/choices.h"
#include "cmd/command_support.h"
#include "cmd/version.h"
#include "pbrt/image/image.h"
#include "pbrt/phases/oriented_file.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;

void RequireSolutions(const OrientedComputation& computation, const ParticlesInput& input) {
    for (size_t w = 0; w < input.settings.wavelengths.size(); ++w)
        if (computation.NumAveraged(w) < computation.NumNeeded())
            throw SceneError(
                input.placeOfArrangement,
                fmt::format("at {:g} nm {} of {} realisations have no solution: the waves of such "
                            "particles are not computed accurately",
                            input.settings.wavelengths[w],
                            computation.NumRealizations() - computation.NumAveraged(w),
                            computation.NumRealizations()));
}

std::string Made(const OrientedComputation& computation, const ParticlesInput& input) {
    nlohmann::ordered_json made;
    made["by"] = fmt::format("Lacquer {}", kVersion);
    made["seed"] = input.settings.seed;
    made["realisations"] = computation.NumRealizations();
    made["refused"] = computation.NumRefused();
    made["energy_error"] = computation.WorstEnergyError();
    made["input"] = nlohmann::ordered_json::parse(input.json);
    return made.dump();
}

void Report(const OrientedBulkTable& table, Console* console) {
    const OrientedGrid grid(table);
    console->Info(fmt::format("{:>8}  {:<38}{:<12}{:<12}{}", "nm", "sigma_s [1/mm] along, mean, across", "g",
                              "error of p", "changed to be reciprocal"));
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        const std::vector<double>& sigma = table.sigmaS[w];
        const std::string range = fmt::format("{:.4g}, {:.4g}, {:.4g}", sigma.front(),
                                              grid.MeanOverIncidences(sigma), sigma.back());
        console->Info(fmt::format(
            "{:>8g}  {:<38}{:<12.4g}{:<12}{:.2g} %", table.wavelengths[w], range, table.g[w],
            table.errorPhase.empty() ? "unknown" : fmt::format("{:.2g} %", 100 * table.errorPhase[w]),
            100 * table.errorReciprocity[w]));
    }
}

}  // namespace

ExitStatus RunOrientedBulk(const ParticlesInput& input, int realizations, const std::string& out,
                           Console* console) {
    if (ExtensionOf(out) == "exr")
        BadOption("out", out, "a name that does not end in .exr, as that of the image beside it does");
    namespace fs = std::filesystem;
    if (fs::exists(out) && !fs::is_regular_file(out))
        BadOption("out", out, "a regular file, as there is an image beside it");
    CheckOutputFile(ImageOfOrientedBulk(out));
    OrientedComputation computation(input.settings, *input.oriented);
    if (realizations < computation.NumNeeded())
        BadOption("realisations", std::to_string(realizations),
                  fmt::format("at least {}, as the average \"medium\" or \"chapter\" is one of pairs",
                              computation.NumNeeded()));
    const int64_t numWavelengths = int64_t(input.settings.wavelengths.size());
    console->Begin("solving", realizations * numWavelengths, "");
    OrientedBulkTable table;
    try {
        computation.AddRealizations(realizations, console);
        console->End();
        if (Console::Signal() != 0) {
            console->Error("stopped by a signal; nothing is written");
            return Console::Signal() == SIGTERM ? ExitStatus::Terminated : ExitStatus::Interrupted;
        }
        RequireSolutions(computation, input);
        table = computation.Table();
    } catch (const SceneError& error) {
        throw SceneError(input.placeOfArrangement, error.Message());
    }
    if (computation.NumRefused() > 0)
        console->Warn(fmt::format("{} of {} solutions did not converge, and are in no average",
                                  computation.NumRefused(), computation.NumRealizations() * numWavelengths));
    table.made = Made(computation, input);
    WriteOrientedBulk(table, out);
    Report(table, console);
    console->Info(fmt::format("{}: {} wavelengths, {} incidences, {} realisations", out, numWavelengths,
                              table.NumIncidences(), computation.NumRealizations()));
    return ExitStatus::Complete;
}

}  // namespace lacquer::cmd
