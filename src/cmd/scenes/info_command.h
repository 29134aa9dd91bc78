// lacquer info: what images and scenes hold.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Everything that the command line of `info` can say.
struct InfoArguments {
    std::vector<std::string> files;
    bool json = false;
};

/// Declares the options on `app`.
void AddInfoOptions(CLI::App& app, InfoArguments& arguments);
/// Prints to stdout, the scene behind the images. A file that cannot be read becomes a message, and the
/// others are still shown.
ExitStatus RunInfo(const InfoArguments& arguments);

}  // namespace lacquer::cmd
