// lacquer whitebalance: colours as they would look under another light.
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

struct WhiteBalanceArguments {
    std::string image, outfile, illuminant, primaries;
    double temperature = 0;
    bool quiet = false;
};

constexpr const char* kPrefixes[] = {"stdillum-", "illum-"};

/// Short names of the illuminants that there are: "D65", "A", "F11", "cieD50".
std::vector<std::string> Illuminants() {
    std::vector<std::string> names;
    for (const std::string& name : NamedSpectra())
        for (const std::string prefix : kPrefixes)
            if (name.starts_with(prefix)) names.push_back(name.substr(prefix.size()));
    return names;
}

void AddWhiteBalanceOptions(CLI::App& app, WhiteBalanceArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--illuminant", a.illuminant, "The light of the scene, which is to look white")
        ->check(OneOf(Illuminants()));
    app.add_option("--temperature", a.temperature, "Or its correlated colour temperature, as daylight [K]")
        ->check(CLI::Range(1000., 25000.));
    app.add_option("--primaries", a.primaries, "Or x,y: its chromaticity");
    app.add_flag("--quiet", a.quiet, "No warnings");
}

Point2 ChromaticityOf(const std::string& text) {
    float x = 0, y = 0;
    int used = 0;
    if (std::sscanf(text.c_str(), "%f,%f%n", &x, &y, &used) != 2 || size_t(used) != text.size() || !(x > 0) ||
        !(y > 0) || !(x + y <= 1))
        BadOption("primaries", text, "x,y above 0 with a sum of at most 1");
    return {x, y};
}

/// What is white in the scene.
Point2 SceneWhite(const WhiteBalanceArguments& a) {
    if (int(!a.illuminant.empty()) + int(a.temperature > 0) + int(!a.primaries.empty()) != 1)
        throw CLI::ValidationError("one of --illuminant, --temperature and --primaries is expected");
    if (!a.primaries.empty()) return ChromaticityOf(a.primaries);
    if (a.temperature > 0) return Chromaticity(SpectrumToXYZ(*DaylightSpectrum(float(a.temperature))));
    for (const std::string prefix : kPrefixes)
        if (const auto spectrum = NamedSpectrum(prefix + a.illuminant))
            return Chromaticity(SpectrumToXYZ(*spectrum));
    return {};
}

ExitStatus RunWhiteBalance(const WhiteBalanceArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    const Point2 white = SceneWhite(a);
    Image image = ReadImageArgument(a.image);
    if (!image.HasRGB()) throw FileError(a.image, "only an image with R, G and B has a white balance");
    WarnOfNonFinite(image, a.image, &console);
    const ColorSpace& space = image.ColorSpaceOrSRGB();
    const glm::mat3 matrix = space.RGBFromXYZ() * WhiteBalance(white, space.White()) * space.XYZFromRGB();
    MapColors(&image, [&](RGB rgb) { return matrix * rgb; });
    WriteImage(image, a.outfile, image.format == PixelFormat::Half);
    return ExitStatus::Complete;
}

constexpr const char* kWhiteBalanceSynopsis =
    "Adapts an image, so that what a light of the scene makes white is white (by Bradford's transform).";

}  // namespace

LACQUER_REGISTER(CommandKind, "whitebalance",
                 (CommandOf<WhiteBalanceArguments, AddWhiteBalanceOptions, RunWhiteBalance>::Make),
                 {.synopsis = kWhiteBalanceSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
