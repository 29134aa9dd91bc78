// The gaussfit command: reads its options, and turns errors into messages and exit statuses.
#include <fmt/format.h>

#include <iostream>

#include "cmd/console.h"
#include "cmd/gaussfit/gaussfit_command.h"
#include "cmd/help/command_help.h"
#include "cmd/program.h"
#include "cmd/report_error.h"
#include "cmd/version.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kGaussfitFooter = R"(
Exit status: 0 all files are written; 1 wrong usage; 3 a file cannot be read or written, or a fit is too bad
to be written; 129, 130 or 143 stopped by a signal (each file is the old or the new one, and whole).)";

ExitStatus Run(Console& console, int argc, char** argv) {
    CLI::App app(
        "Fits Gaussians to the lobes of rough boundaries: the tables of the product estimators.\n"
        "Usage: gaussfit [OPTIONS] [MODEL ...]",
        "gaussfit");
    app.footer(kGaussfitFooter);
    app.set_version_flag("--version", fmt::format("gaussfit {}", kVersion));
    GaussfitArguments arguments;
    AddGaussfitOptions(app, arguments);
    TellUsageOnce(app);
    AddHelpAs(app, [&] { return std::vector<CommandHelp>{Describe(app)}; });
    try {
        app.parse(argc, argv);
        return RunGaussfit(arguments);
    } catch (const CLI::Success& e) {
        app.exit(e, std::cout, std::cerr);
        return ExitStatus::Complete;
    } catch (const CLI::ValidationError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const CLI::ParseError& e) {
        console.Error(fmt::format("{} (gaussfit --help lists the options)", e.what()));
        return ExitStatus::Usage;
    } catch (const SceneError& e) {  // there is no scene: what a file holds
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
