// lacquer makeequiarea: images of all directions in the mapping of pbrt-v4's environment maps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "pbrt/image/environment.h"

namespace lacquer::cmd {
namespace {

struct MakeEquiareaArguments {
    std::string image, outfile, mapping = "latlong";
    int resolution = 0;
    bool quiet = false;
};

void AddMakeEquiareaOptions(CLI::App& app, MakeEquiareaArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--mapping", a.mapping, "How the directions lie in the image")
        ->check(OneOf(EnvironmentMappingNames()))
        ->capture_default_str();
    app.add_option("--resolution", a.resolution, "Pixels a side; 0: as many as the image has")
        ->check(CLI::Range(0, kMaxImageSide))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

ExitStatus RunMakeEquiarea(const MakeEquiareaArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    const Image image = ReadImageArgument(a.image);
    const EnvironmentMapping mapping = EnvironmentMappingOf(a.mapping);
    if (const std::string why = WhyNotOfMapping(image.Resolution(), mapping); !why.empty())
        throw FileError(a.image, why);
    WarnOfNonFinite(image, a.image, &console);
    const Int2 size = image.Resolution();
    if (mapping == EnvironmentMapping::LatLong && size.x != 2 * size.y)
        console.Warn(fmt::format("{}: {} x {} pixels; the whole sphere is twice as wide as high", a.image,
                                 size.x, size.y));
    const int side = a.resolution > 0 ? a.resolution : EqualAreaSide(image.Resolution(), mapping);
    WriteImage(ToEqualArea(image, mapping, side), a.outfile, image.format == PixelFormat::Half);
    console.Info(fmt::format("{}: {} x {} pixels", a.outfile, side, side));
    return ExitStatus::Complete;
}

constexpr const char* kMakeEquiareaSynopsis =
    "Resamples an image of all directions to the square, equal-area mapping of pbrt-v4's environment maps.\n"
    "Lacquer's light \"infinite\" reads the others as they are (\"string mapping\").";

}  // namespace

LACQUER_REGISTER(CommandKind, "makeequiarea",
                 (CommandOf<MakeEquiareaArguments, AddMakeEquiareaOptions, RunMakeEquiarea>::Make),
                 {.synopsis = kMakeEquiareaSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
