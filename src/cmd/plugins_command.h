// lacquer plugins: the names that scene files may use.
#pragma once

#include <CLI/CLI.hpp>

#include "cmd/exit_status.h"

namespace lacquer {

struct PluginsArguments {};

/// Declares the options on `app`: there are none.
void AddPluginsOptions(CLI::App& app, PluginsArguments& arguments);
/// Prints a line for each plugin: its kind, a tab, its name.
ExitStatus RunPlugins(const PluginsArguments& arguments);

}  // namespace lacquer
