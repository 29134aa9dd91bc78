// Command "capture": maps of a flat sample from flash photographs on a printed card.
#include "cmd/capture/capture_job.h"
#include "cmd/command.h"
#include "cmd/sibling_program.h"

namespace lacquer::cmd {
namespace {

ExitStatus RunCapture(const CaptureArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    if (!a.card.empty()) return WriteCard(a, &console);
    CheckCaptureArguments(a);
    if (a.prior.IsGiven()) {
        std::vector<std::string> words{"capture"};
        words.insert(words.end(), a.words.begin(), a.words.end());
        GoOnAsMaterialgan(words);
    }
    return Capture(a, MakeTexelFitter().get(), &console);
}

constexpr const char* kCaptureSynopsis =
    "Makes maps of a flat sample (albedo, normals, roughness, specular albedo) from flash photographs that\n"
    "show it within a printed card, and a material of them that scenes use.\n"
    "Usage: lacquer capture --card card.svg [--size CM]\n"
    "       lacquer capture [OPTIONS] PHOTOS/ --out DIR\n"
    "       lacquer capture [OPTIONS] --views views.json --out DIR";
constexpr const char* kCaptureFooter = R"(
Exit status: 0 everything is written; 1 wrong usage; 2 photographs or views are wrong; 3 a file cannot be read
or written; 4 the fit came to values that are no numbers (DIR has the last good ones); 5 stopped by
--time-limit, 129, 130 or 143 by a signal (DIR has the maps so far).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "capture", (CommandOf<CaptureArguments, AddCaptureOptions, RunCapture>::Make),
                 {.synopsis = kCaptureSynopsis, .footer = kCaptureFooter});

}  // namespace lacquer::cmd
