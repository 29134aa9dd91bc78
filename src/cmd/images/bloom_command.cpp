// lacquer bloom: light around bright pixels.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "pbrt/image/operations.h"

namespace lacquer::cmd {
namespace {

struct BloomArguments {
    std::string image, outfile;
    BloomOptions options;
    bool quiet = false;
};

void AddBloomOptions(CLI::App& app, BloomArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--level", a.options.level, "Pixels shine of which some colour exceeds this")->required();
    app.add_option("--scale", a.options.scale, "Of the light around")
        ->check(CLI::Range(0., 1e6))
        ->capture_default_str();
    app.add_option("--width", a.options.width, "Of the blur [pixels]")
        ->check(CLI::Range(1, 4096))
        ->capture_default_str();
    app.add_option("--iterations", a.options.iterations, "Blurs of blurs: the light reaches as much farther")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

ExitStatus RunBloom(const BloomArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    Image image = ReadImageArgument(a.image);
    WarnOfNonFinite(image, a.image, &console);
    RequireColors(image, a.image);
    const int64_t bright = Bloom(&image, a.options);
    if (bright == 0) console.Warn(fmt::format("{}: no pixel exceeds {}", a.image, a.options.level));
    WriteImage(image, a.outfile, image.format == PixelFormat::Half);
    console.Info(fmt::format("{}: {} pixels shine", a.outfile, bright));
    return ExitStatus::Complete;
}

constexpr const char* kBloomSynopsis = "Adds the light around bright pixels that lenses and eyes make.";

}  // namespace

LACQUER_REGISTER(CommandKind, "bloom", (CommandOf<BloomArguments, AddBloomOptions, RunBloom>::Make),
                 {.synopsis = kBloomSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
