// Command "example": says its number.
// Stands in src/cmd/scenes. Run: example --number 7
#include <fmt/format.h>

#include "cmd/command.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {
namespace {

struct Arguments {
    int number = 0;
};

void AddOptions(CLI::App& app, Arguments& arguments) {
    app.add_option("--number", arguments.number, "what it says");
}

ExitStatus Run(const Arguments& arguments) {
    fmt::print("{}\n", arguments.number);
    return ExitStatus::Complete;
}

}  // namespace

LACQUER_REGISTER(CommandKind, "example", (CommandOf<Arguments, AddOptions, Run>::Make),
                 {.synopsis = "Says a number.", .footer = ""});

}  // namespace lacquer::cmd
