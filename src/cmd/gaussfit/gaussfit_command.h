// gaussfit: fits the tables of lobes, writes them, and reports how good they are.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line can say.
struct GaussfitArguments {
    std::vector<std::string> models;  ///< none: all
    std::string out = "data/lobes";
    std::string report;  ///< empty: no report
    bool noFit = false;
    int threads = 0;
    bool quiet = false;
};

/// Declares the options on `app`.
void AddGaussfitOptions(CLI::App& app, GaussfitArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunGaussfit(const GaussfitArguments& arguments);

}  // namespace lacquer::cmd
