#include "cmd/command.h"

#include <fmt/format.h>

#include <algorithm>

#include "cmd/help/command_help.h"
#include "cmd/version.h"

namespace lacquer::cmd {

namespace {

/// The help of all commands, the default one first.
std::vector<CommandHelp> DescribeAll() {
    std::vector<std::string> names = Registry<CommandKind>::Names();
    std::stable_partition(names.begin(), names.end(),
                          [](const std::string& name) { return name == kDefaultCommand; });
    std::vector<CommandHelp> all;
    for (const std::string& name : names) {
        const std::unique_ptr<Command> command = Registry<CommandKind>::Find(name)();
        all.push_back(Describe(*MakeApp(name, *command), name));
    }
    return all;
}

}  // namespace

std::unique_ptr<CLI::App> MakeApp(const std::string& name, Command& command) {
    const CommandKind::Traits traits = Registry<CommandKind>::TraitsOf(name);
    std::string synopsis = traits.synopsis, line = fmt::format("lacquer {}", name);
    if (name == kDefaultCommand) {
        line = "lacquer";
        synopsis += "\nOther commands: lacquer help lists them.";
    }
    auto app = std::make_unique<CLI::App>(synopsis, line);
    app->footer(traits.footer);
    command.AddOptions(*app);
    app->set_version_flag("--version", fmt::format("lacquer {}", kVersion));
    TellUsageOnce(*app);
    if (name == kDefaultCommand) AddHelpAs(*app, DescribeAll);
    return app;
}

}  // namespace lacquer::cmd
