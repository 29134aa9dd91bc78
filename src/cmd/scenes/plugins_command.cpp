// lacquer plugins: the names that scene files may use.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "cmd/command.h"
#include "cmd/exit_status.h"
#include "layered/estimator.h"
#include "pbrt/base/camera.h"
#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/light.h"
#include "pbrt/base/material.h"
#include "pbrt/base/medium.h"
#include "pbrt/base/sampler.h"
#include "pbrt/base/shape.h"
#include "pbrt/film/sensor.h"
#include "pbrt/scene/builder.h"

namespace lacquer::cmd {

namespace {

struct PluginsArguments {
    bool markdown = false;
};

struct Names {
    std::string kind;
    std::vector<std::string> names;
};

template <class... Kinds>
std::vector<Names> Registered() {
    return {{Kinds::kKind, Registry<Kinds>::Names()}...};
}

std::vector<Names> AllNames() {
    std::vector<Names> all =
        Registered<CameraKind, FilmKind, FilterKind, SamplerKind, IntegratorKind, LightSamplerKind, LightKind,
                   AreaLightKind, MaterialKind, FloatTextureKind, SpectrumTextureKind, ShapeKind, MediumKind,
                   PhaseKind, layered::LayeredEstimatorKind, layered::LayeredPdfKind>();
    all.push_back({"accelerator", AcceleratorNames()});
    all.push_back({"sensor", SensorNames()});
    all.push_back({"colour space", ColorSpace::Names()});
    return all;
}

void PrintMarkdown() {
    fmt::print(
        "# Every name that the program knows\n\n"
        "Made by `lacquer plugins --markdown`; [format.md](format.md) says what is particular about them.\n\n"
        "| kind | names |\n| --- | --- |\n");
    for (const Names& all : AllNames()) fmt::print("| {} | `{}` |\n", all.kind, fmt::join(all.names, "`, `"));
}

void AddPluginsOptions(CLI::App& app, PluginsArguments& arguments) {
    app.add_flag("--markdown", arguments.markdown, "as the table of docs/plugins.md");
}

ExitStatus RunPlugins(const PluginsArguments& arguments) {
    if (arguments.markdown) {
        PrintMarkdown();
        return ExitStatus::Complete;
    }
    for (const Names& all : AllNames())
        for (const std::string& name : all.names) fmt::print("{}\t{}\n", all.kind, name);
    return ExitStatus::Complete;
}

constexpr const char* kPluginsSynopsis =
    "Lists the names that scene files may use: a line each of kind, tab, name.";
constexpr const char* kPluginsFooter = "\nExit status: 0 the list is complete; 1 wrong usage.";

}  // namespace

LACQUER_REGISTER(CommandKind, "plugins", (CommandOf<PluginsArguments, AddPluginsOptions, RunPlugins>::Make),
                 {.synopsis = kPluginsSynopsis, .footer = kPluginsFooter});

}  // namespace lacquer::cmd
