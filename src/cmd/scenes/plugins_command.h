// lacquer plugins: the names that scene files may use.
#pragma once

#include <CLI/CLI.hpp>

#include "cmd/exit_status.h"

namespace lacquer::cmd {

struct PluginsArguments {
    bool markdown = false;
};

/// Declares the options on `app`.
void AddPluginsOptions(CLI::App& app, PluginsArguments& arguments);
/// Prints a line for each plugin: its kind, a tab, its name; or a table of them.
ExitStatus RunPlugins(const PluginsArguments& arguments);

}  // namespace lacquer::cmd
