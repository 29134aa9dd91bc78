// The commands of lacquer-materialgan and their options.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cmd/capture/capture_arguments.h"
#include "cmd/exit_status.h"
#include "cmd/help/command_help.h"

namespace lacquer::cmd {

struct MaterialganArguments {
    std::string file, maps, latentsA, latentsB, out;
    int threads = 0;
    bool quiet = false;
    uint64_t seed = 1;
    // train
    int resolution = 64, batch = 16;
    std::string featureMaps = "128:32", objective = "vae";
    double hours = 0;
    int64_t steps = 0;
    bool resume = false;
    // sample, morph, project
    int count = 8;
    double psi = 1;
    std::string space = "w+n";
    int iterations = 500;
    // evaluate
    std::string sheet;
    int views = 3, fitIterations = 240, texelIterations = 500;
    std::optional<double> priorWeight;
    // capture
    CaptureArguments capture;
};

/// One of the commands: its options as an app of its own, and what it does.
struct MaterialganCommand {
    CLI::App* app;
    ExitStatus (*run)(const MaterialganArguments& arguments);
};
/// Adds all of them to `app`; they fill in `arguments`.
std::vector<MaterialganCommand> AddMaterialganCommands(CLI::App& app, MaterialganArguments& arguments);

/// Of each command, for manual pages and completions.
std::vector<CommandHelp> MaterialganHelp();

ExitStatus RunTrain(const MaterialganArguments& arguments);
ExitStatus RunMaterials(const MaterialganArguments& arguments);
ExitStatus RunSample(const MaterialganArguments& arguments);
ExitStatus RunProject(const MaterialganArguments& arguments);
ExitStatus RunMorph(const MaterialganArguments& arguments);
ExitStatus RunEvaluate(const MaterialganArguments& arguments);
ExitStatus RunCaptureWithPrior(const MaterialganArguments& arguments);
ExitStatus RunInfo(const MaterialganArguments& arguments);

}  // namespace lacquer::cmd
