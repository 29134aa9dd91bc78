// lacquer render: from a scene file to an image.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `render` can say.
struct RenderArguments {
    std::vector<std::string> scenes;  ///< none, or "-": standard input
    std::string outfile;
    std::optional<int> spp;
    int seed = 0;
    int threads = 0;
    bool quiet = false, quick = false, stats = false, writePartialImages = false;
    bool disablePixelJitter = false, disableWavelengthJitter = false, disableTextureFiltering = false;
    bool disableImageTextures = false, forceDiffuse = false, pixelStats = false;
    float displacementEdgeScale = 1;
    std::string cropWindow, pixelBounds, pixel, resolution, sampleRange;
    std::string mseReferenceImage, mseReferenceOut;
    std::string displayServer;
    int textureMegabytes = 512;
    std::string textureCache;
    std::string renderCoordSys = "cameraworld";
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
