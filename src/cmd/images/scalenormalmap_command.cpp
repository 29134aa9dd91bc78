// lacquer scalenormalmap: bumps higher or lower.
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

struct ScaleNormalMapArguments {
    std::string image, outfile;
    double scale = 1;
    bool quiet = false;
};

void AddScaleNormalMapOptions(CLI::App& app, ScaleNormalMapArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--scale", a.scale, "Of x and y of the normals")
        ->check(CLI::Range(-1e6, 1e6))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No warnings");
}

ExitStatus RunScaleNormalMap(const ScaleNormalMapArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    // Normal maps hold vectors and not colours: their bytes are linear.
    Image image = ReadImageArgument(a.image, ColorEncoding());
    if (!image.HasRGB()) throw FileError(a.image, "a normal map needs the channels R, G and B");
    WarnOfNonFinite(image, a.image, &console);
    ScaleNormals(&image, float(a.scale));
    // What is written as bytes is encoded once more.
    if (HoldsBytes(a.outfile))
        MapColors(&image, [](RGB rgb) {
            const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
            return RGB(srgb.ToLinear(rgb.x), srgb.ToLinear(rgb.y), srgb.ToLinear(rgb.z));
        });
    WriteImage(image, a.outfile, image.format == PixelFormat::Half);
    return ExitStatus::Complete;
}

constexpr const char* kScaleNormalMapSynopsis =
    "Scales x and y of the normals of a normal map, and makes them unit again. Bytes are linear.";

}  // namespace

LACQUER_REGISTER(CommandKind, "scalenormalmap",
                 (CommandOf<ScaleNormalMapArguments, AddScaleNormalMapOptions, RunScaleNormalMap>::Make),
                 {.synopsis = kScaleNormalMapSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
