// lacquer merge: renders of one picture with different samples become one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `merge` can say.
struct MergeArguments {
    std::vector<std::string> images;
    std::string outfile;
    bool quiet = false;
};

/// Declares the options on `app`.
void AddMergeOptions(CLI::App& app, MergeArguments& arguments);
/// Errors of the library pass through, for main to report.
ExitStatus RunMerge(const MergeArguments& arguments);

}  // namespace lacquer::cmd
