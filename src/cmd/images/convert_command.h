// lacquer convert: an image in another format, size, exposure or colour space; a scene in another spelling.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `convert` can say.
struct ConvertArguments {
    std::string input, output;
    std::string crop, resize;      ///< empty: none
    double exposure = 0;           ///< [stops]
    std::string colorSpace;        ///< empty: as it is
    std::string toneMap = "none";  ///< see ToneMapNames()
    std::string layer;             ///< empty: the whole image
    std::vector<std::string> channels;
    int repeat = 1;
    bool flipY = false, blackAndWhite = false, preserveColors = false;
    double scale = 1, gamma = 1;
    std::optional<double> clamp, despike, maxLuminance;  ///< luminances
    bool half = false, quiet = false;
    // Any of these: the input is a scene.
    bool format = false, toPly = false, upgrade = false;
    std::string outDir;      ///< of PLY files; empty: beside the scene
    int minTriangles = 200;  ///< smaller meshes stay in the scene
    bool IsForScene() const { return format || toPly || upgrade; }
};

/// Declares the options on `app`.
void AddConvertOptions(CLI::App& app, ConvertArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunConvert(const ConvertArguments& arguments);

}  // namespace lacquer::cmd
