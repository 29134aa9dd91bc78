// Command "materialgan": the program of that name, which needs libtorch and is a file of its own.
#include "cmd/command.h"
#include "cmd/exit_status.h"
#include "cmd/sibling_program.h"

namespace lacquer::cmd {
namespace {

struct SiblingArguments {
    std::vector<std::string> words;
};

void AddSiblingOptions(CLI::App& app, SiblingArguments&) {
    // All words are that program's, --help of its commands included.
    app.prefix_command();
    app.set_help_flag();
}

ExitStatus RunMaterialgan(const SiblingArguments& a) { GoOnAsMaterialgan(a.words); }

constexpr const char* kMaterialganSynopsis =
    "Trains a generator of materials and uses it (lacquer-materialgan, where it was built).\n"
    "Usage: lacquer materialgan train | sample | project | morph | evaluate | info ...";
constexpr const char* kMaterialganFooter = R"(
`lacquer materialgan COMMAND --help` explains each command.
Exit status: 0 all files are written; 1 wrong usage, or a build without lacquer-materialgan; 3 a file cannot be
read or written; 129, 130 or 143 stopped by a signal.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "materialgan",
                 (CommandOf<SiblingArguments, AddSiblingOptions, RunMaterialgan>::Make),
                 {.synopsis = kMaterialganSynopsis, .footer = kMaterialganFooter});

}  // namespace lacquer::cmd
