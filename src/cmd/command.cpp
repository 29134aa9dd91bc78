#include "cmd/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "cmd/choices.h"
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

/// Words with blanks between, in lines of a terminal's width.
std::string Wrapped(const std::vector<std::string>& words) {
    constexpr size_t kWidth = 100;
    std::string text, line;
    for (const std::string& word : words) {
        if (line.size() + word.size() > kWidth) {
            text += line + "\n";
            line.clear();
        }
        line += (line.empty() ? "  " : " ") + word;
    }
    return text + line;
}

}  // namespace

GivenCommand MakeGivenCommand(const std::string& command, std::vector<std::string> words) {
    GivenCommand given{command, std::move(words)};
    for (const std::string& word : given.words) {
        const bool isPlain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
            return std::isalnum((unsigned char)c) || std::strchr("-_./,:=@+%", c);
        });
        std::string quoted = "'";
        for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
        given.line += " " + (isPlain ? word : quoted + "'");
    }
    return given;
}

std::unique_ptr<CLI::App> MakeApp(const std::string& name, Command& command) {
    const CommandKind::Traits traits = Registry<CommandKind>::TraitsOf(name);
    std::string synopsis = traits.synopsis, line = fmt::format("lacquer {}", name);
    if (name == kDefaultCommand) {
        line = "lacquer";
        std::vector<std::string> others = Registry<CommandKind>::Names();
        std::erase(others, name);
        synopsis += "\nOther commands, which `lacquer help` explains:\n" + Wrapped(others);
    }
    auto app = std::make_unique<CLI::App>(synopsis, line);
    app->footer(traits.footer);
    command.AddOptions(*app);
    ExpectFiniteNumbers(*app);
    app->set_version_flag("--version", fmt::format("lacquer {}", kVersion));
    TellUsageOnce(*app);
    if (name == kDefaultCommand) AddHelpAs(*app, DescribeAll);
    return app;
}

}  // namespace lacquer::cmd
