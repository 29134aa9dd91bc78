// lacquer render: from a scene file to an image.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cmd/exit_status.h"
#include "pbrt/scene/scene_options.h"

namespace lacquer::cmd {

/// Everything that the command line of `render` can say.
struct RenderArguments {
    std::vector<std::string> scenes;  ///< none, or "-": standard input
    std::string outfile;
    std::optional<int> spp;
    GivenOptions options;  ///< those that Option directives can set as well
    int threads = 0;
    bool quiet = false, quick = false, stats = false, writePartialImages = false;
    bool disableImageTextures = false;
    std::string cropWindow, pixelBounds, pixel, resolution, sampleRange;
    std::string displayServer;
    int textureMegabytes = 512;
    std::string textureCache;
    std::string logLevel = "error", logFile;
    std::string estimator, layeredPdf;
    std::optional<double> timeLimit;
    std::string statsJson;
    std::vector<std::string> aovs;
    int cryptomatteRanks = 6;
};

/// Declares the options on `app`.
void AddRenderOptions(CLI::App& app, RenderArguments& arguments);
/// Renders. Errors of the library pass through, for main to report.
ExitStatus RunRender(const RenderArguments& arguments);

}  // namespace lacquer::cmd
