// The lacquer command: finds the command that is meant, runs it, and turns errors into messages and exit
// statuses.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <system_error>

#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/help/pbrt_names.h"
#include "cmd/program.h"
#include "cmd/report_error.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {
namespace {

/// Spells options as CLI11 knows them (NormalizedName()).
std::vector<std::string> NormalizeOptions(const CLI::App& app, std::vector<std::string> arguments) {
    for (std::string& argument : arguments) {
        if (argument.size() < 3 || argument[0] != '-') continue;
        if (std::isdigit((unsigned char)argument[1]) || argument[1] == '.') continue;  // a negative number
        const size_t equals = argument.find('=');
        const std::string name = NormalizedName(argument.substr(0, equals));
        for (const CLI::Option* option : app.get_options())
            for (const std::string& known : option->get_lnames())
                if (NormalizedName(known) == name)
                    argument = fmt::format("--{}{}", known,
                                           equals == std::string::npos ? "" : argument.substr(equals));
    }
    return arguments;
}

std::string NearestOption(const CLI::App& app, const std::vector<std::string>& arguments) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& argument : arguments) {
        const std::string name = argument.substr(0, argument.find('='));
        if (name.size() > 2 && name[0] == '-' && std::find(names.begin(), names.end(), name) == names.end())
            return DidYouMean(name, names);
    }
    return {};
}

/// Runs the command `name` with the words behind its name.
int RunCommand(const std::string& name, std::vector<std::string> words) {
    const std::unique_ptr<Command> command = Registry<CommandKind>::Find(name)();
    const std::unique_ptr<CLI::App> app = MakeApp(name, *command);
    GivenCommand given = MakeGivenCommand(app->get_name(), words);
    words = given.words = NormalizeOptions(*app, std::move(words));
    try {
        app->parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::Success& e) {
        app->exit(e, std::cout, std::cerr);
        return int(ExitStatus::Complete);
    } catch (const CLI::ParseError& e) {
        if (name == kDefaultCommand)
            for (const std::string& word : words)
                if (const std::string answer = AnswerToPbrtOption(word); !answer.empty())
                    throw CLI::ValidationError(fmt::format("{} of pbrt: {}", word, answer));
        Console(ConsoleStyle::Detect(false))
            .Error(fmt::format("{}{} ({} --help lists the options)", e.what(), NearestOption(*app, words),
                               app->get_name()));
        return int(ExitStatus::Usage);
    }
    return command->Run(given);
}

/// A first word that is no file and looks like a command was meant as one.
void CheckCommand(const std::string& word) {
    const bool isName = !word.empty() && std::isalpha((unsigned char)word[0]) &&
                        std::all_of(word.begin(), word.end(),
                                    [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; });
    std::error_code ignored;
    if (!isName || std::filesystem::exists(word, ignored)) return;
    if (const std::string answer = AnswerToPbrtCommand(word); !answer.empty())
        throw CLI::ValidationError(fmt::format("{} of pbrt: {}", word, answer));
    std::vector<std::string> names = Registry<CommandKind>::Names();
    std::string nearest = DidYouMean(NormalizedName(word), names);
    if (nearest.empty()) nearest = "; lacquer help lists the commands";
    throw CLI::ValidationError(fmt::format("\"{}\" is no command and no file{}", word, nearest));
}

int Run(std::vector<std::string> words) {
    if (!words.empty() && !Registry<CommandKind>::Find(words[0])) CheckCommand(words[0]);
    if (words.empty() || !Registry<CommandKind>::Find(words[0]))
        return RunCommand(kDefaultCommand, std::move(words));
    const std::string name = words[0];
    words.erase(words.begin());
    return RunCommand(name, std::move(words));
}

int RunGuarded(int argc, char** argv) {
    Console console(ConsoleStyle::Detect(false));
    try {
        return Run(std::vector<std::string>(argv + 1, argv + argc));
    } catch (const std::system_error&) {
        // fmt::print() throws where standard output takes no more, which RunProgram() tells.
        return int(std::ferror(stdout) ? ExitStatus::File : ReportError(console));
    } catch (const std::exception&) {
        return int(ReportError(console));
    }
}

}  // namespace
}  // namespace lacquer::cmd

int main(int argc, char** argv) { return lacquer::cmd::RunProgram(lacquer::cmd::RunGuarded, argc, argv); }
