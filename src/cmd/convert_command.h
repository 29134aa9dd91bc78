// lacquer convert: an image in another format, size, exposure or colour space.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "cmd/exit_status.h"

namespace lacquer {

/// Everything that the command line of `convert` can say.
struct ConvertArguments {
    std::string input, output;
    std::string crop, resize;      ///< empty: none
    double exposure = 0;           ///< [stops]
    std::string colorSpace;        ///< empty: as it is
    std::string toneMap = "none";  ///< see ToneMapNames()
    bool half = false, quiet = false;
};

/// Declares the options on `app`.
void AddConvertOptions(CLI::App& app, ConvertArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunConvert(const ConvertArguments& arguments);

}  // namespace lacquer
