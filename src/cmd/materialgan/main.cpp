// The lacquer-materialgan command: reads its options, and turns errors into messages and exit statuses.
#include <fmt/format.h>

#include <iostream>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/console.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "cmd/program.h"
#include "cmd/report_error.h"
#include "cmd/version.h"
#include "materialgan/material_prior.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kMaterialganFooter = R"(
Exit status: 0 all files are written; 1 wrong usage; 2 not enough memory; 3 a file cannot be read or
written; 4 a training came to a loss that is no number; 129, 130 or 143 stopped
by a signal (what there is then is written, and training goes on with --resume). capture: those of
lacquer capture.)";

/// Usage error for a first word that is no command: CLI11 would only say that one is required.
void CheckCommand(int argc, char** argv, const std::vector<MaterialganCommand>& commands) {
    if (argc < 2 || argv[1][0] == '-') return;
    std::vector<std::string> names;
    for (const MaterialganCommand& command : commands) names.push_back(command.app->get_name());
    CheckName("command", argv[1], names);
}

ExitStatus Run(Console& console, int argc, char** argv) {
    CLI::App app(
        "A generator of materials, for captures from few photographs.\n"
        "Usage: lacquer-materialgan COMMAND [OPTIONS] ...",
        "lacquer-materialgan");
    app.footer(kMaterialganFooter);
    app.set_version_flag("--version", fmt::format("lacquer-materialgan {}", kVersion));
    MaterialganArguments arguments;
    const std::vector<MaterialganCommand> commands = AddMaterialganCommands(app, arguments);
    TellUsageOnce(app);
    AddHelpAs(app, MaterialganHelp);
    try {
        CheckCommand(argc, argv, commands);
        app.parse(argc, argv);
        const std::vector<std::string> words(argv + 1, argv + argc);
        arguments.capture.command = MakeGivenCommand("lacquer", words).line;
        for (const MaterialganCommand& command : commands)
            if (command.app->parsed()) return command.run(arguments);
        return ExitStatus::Usage;
    } catch (const CLI::Success& e) {
        app.exit(e, std::cout, std::cerr);
        return ExitStatus::Complete;
    } catch (const CLI::ValidationError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const CLI::ParseError& e) {
        console.Error(fmt::format("{} (lacquer-materialgan --help lists the commands)", e.what()));
        return ExitStatus::Usage;
    } catch (const SceneError& e) {
        if (app.got_subcommand("capture")) throw;  // what photographs and views hold is that command's scene
        console.Error(e.what());
        return ExitStatus::File;
    }
}

int RunGuarded(int argc, char** argv) {
    Console console(ConsoleStyle::Detect(false));
    try {
        return int(Run(console, argc, argv));
    } catch (const std::exception& e) {
        if (!materialgan::IsOutOfMemory(e)) return int(ReportError(console));
        console.Error("not enough memory");
        return int(ExitStatus::Scene);
    }
}

}  // namespace
}  // namespace lacquer::cmd

int main(int argc, char** argv) { return lacquer::cmd::RunProgram(lacquer::cmd::RunGuarded, argc, argv); }
