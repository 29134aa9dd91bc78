// lacquer bsdf: what a material of a scene does to light, as plots and numbers.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `bsdf` can say.
struct BsdfArguments {
    std::vector<std::string> scenes;
    std::string material, wi, out;
    std::vector<std::string> exports;  ///< names of tables
    std::string reference;             ///< material to tell color differences from; empty: none
    std::string uv = "0.5,0.5";
    std::vector<std::string> estimators;  ///< none: all that apply
    std::string layeredPdf;               ///< empty: the material's
    int resolution = 256;
    int samples = 32;
    int seed = 0;
    int threads = 0;
    bool quiet = false;
};

/// Declares the options on `app`.
void AddBsdfOptions(CLI::App& app, BsdfArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunBsdf(const BsdfArguments& arguments);

}  // namespace lacquer::cmd
