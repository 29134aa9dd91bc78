// lacquer help: the help of a command, or all commands with a line each.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/exit_status.h"
#include "cmd/help/command_help.h"

namespace lacquer::cmd {
namespace {

struct HelpArguments {
    std::string name;
};

void AddHelpOptions(CLI::App& app, HelpArguments& a) {
    app.add_option("command", a.name, "Whose help is wanted");
}

ExitStatus RunHelp(const HelpArguments& a) {
    const std::vector<std::string> names = Registry<CommandKind>::Names();
    if (!a.name.empty()) {
        if (const std::string why = WhyUnknown(a.name, names); !why.empty()) throw CLI::ValidationError(why);
        const std::unique_ptr<Command> command = Registry<CommandKind>::Find(a.name)();
        fmt::print("{}", MakeApp(a.name, *command)->help());
        return ExitStatus::Complete;
    }
    fmt::print("lacquer scene.pbrt renders; other commands (lacquer help COMMAND tells more):\n\n");
    for (const std::string& name : names) {
        const std::unique_ptr<Command> command = Registry<CommandKind>::Find(name)();
        fmt::print("  {:<16}{}\n", name, Describe(*MakeApp(name, *command), name).summary);
    }
    return ExitStatus::Complete;
}

constexpr const char* kHelpFooter = "\nExit status: 0 all is done; 1 there is no such command.";
constexpr const char* kHelpSynopsis = "Shows the help of a command, or a list of all.";

}  // namespace

LACQUER_REGISTER(CommandKind, "help", (CommandOf<HelpArguments, AddHelpOptions, RunHelp>::Make),
                 {.synopsis = kHelpSynopsis, .footer = kHelpFooter});

}  // namespace lacquer::cmd
