// The lacquer-materialgan command: reads its options, and turns errors into messages and exit statuses.
#include <fmt/format.h>

#include <iostream>

#include "cmd/command.h"
#include "cmd/console.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "cmd/program.h"
#include "cmd/report_error.h"
#include "cmd/version.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kMaterialganFooter = R"(
Exit status: 0 all files are written; 1 wrong usage; 3 a file cannot be read or written; 129, 130 or 143 stopped
by a signal (what there is then is written, and training goes on with --resume).)";

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
    } catch (const std::exception&) {
        return int(ReportError(console));
    }
}

}  // namespace
}  // namespace lacquer::cmd

int main(int argc, char** argv) { return lacquer::cmd::RunProgram(lacquer::cmd::RunGuarded, argc, argv); }
