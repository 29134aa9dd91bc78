// lacquer falsecolor: values as colours of a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "compare/color_map.h"

namespace lacquer::cmd {
namespace {

struct FalsecolorArguments {
    std::string image, outfile, ramp;
    std::optional<double> maxvalue;
    std::vector<std::string> channels;
    bool plusminus = false, quiet = false;
};

void AddFalsecolorOptions(CLI::App& app, FalsecolorArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--maxvalue", a.maxvalue, "The value of the brightest colour; default: the largest one");
    app.add_flag("--plusminus", a.plusminus,
                 "Positive values green, negative ones red; else the map of `lacquer diff`");
    AddChannels(app, a.channels);
    app.add_option("--ramp", a.ramp, "An image of the map as well, from 0 to the brightest colour")
        ->type_name(kFile);
    app.add_flag("--quiet", a.quiet, "No information");
}

std::vector<float> MeansOf(const Image& image, const std::vector<int>& channels) {
    std::vector<float> means;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x) {
            float sum = 0;
            for (const int c : channels) sum += image.Get({x, y}, c);
            means.push_back(sum / float(channels.size()));
        }
    return means;
}

Image Colored(const std::vector<float>& values, Int2 size, float largest, bool plusMinus) {
    if (!plusMinus) return compare::ColoredErrors(values, size, largest);
    Image image(size, {"R", "G", "B"});
    image.SetColorSpace(&ColorSpace::SRGB());
    for (size_t i = 0; i < values.size(); ++i) {
        const float v = std::clamp(values[i] / largest, -1.f, 1.f);
        image.Pixels()[3 * i] = std::max(-v, 0.f);
        image.Pixels()[3 * i + 1] = std::max(v, 0.f);
        if (std::isnan(v)) image.Pixels()[3 * i + 2] = 1;
    }
    return image;
}

ExitStatus RunFalsecolor(const FalsecolorArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    if (a.maxvalue && !(float(*a.maxvalue) > 0 && std::isfinite(float(*a.maxvalue))))
        BadOption("maxvalue", fmt::format("{}", *a.maxvalue), "a number above 0, as a 32-bit float has it");
    CheckImageOutput(a.outfile);
    if (!a.ramp.empty()) CheckImageOutput(a.ramp);
    CheckDifferent("--ramp", a.ramp, a.outfile);
    const Image image = ReadImageArgument(a.image);
    WarnOfNonFinite(image, a.image, &console);
    const std::vector<float> values = MeansOf(image, ChannelsOf(image, a.channels));
    float largest = 0;
    for (const float v : values)
        if (std::isfinite(v)) largest = std::max(largest, a.plusminus ? std::abs(v) : v);
    if (a.maxvalue) largest = float(*a.maxvalue);
    if (!(largest > 0)) largest = 1;
    Image colored = Colored(values, image.Resolution(), largest, a.plusminus);
    colored.dataWindow = image.dataWindow;
    colored.fullResolution = image.fullResolution;
    WriteImage(colored, a.outfile);
    if (!a.ramp.empty()) {
        constexpr int kWidth = 256, kHeight = 24;
        std::vector<float> ramp;
        for (int i = 0; i < kWidth * kHeight; ++i) {
            const float t = float(i % kWidth) / (kWidth - 1);
            ramp.push_back(largest * (a.plusminus ? 2 * t - 1 : t));
        }
        WriteImage(Colored(ramp, {kWidth, kHeight}, largest, a.plusminus), a.ramp);
    }
    console.Info(fmt::format("{}: mean of the channels; {} {:.6g}", a.outfile,
                             a.plusminus ? "green and red are plus and minus" : "black is 0, pale yellow",
                             largest));
    return ExitStatus::Complete;
}

constexpr const char* kFalsecolorSynopsis =
    "Shows values as colours: the mean of the channels of each pixel.";

}  // namespace

LACQUER_REGISTER(CommandKind, "falsecolor",
                 (CommandOf<FalsecolorArguments, AddFalsecolorOptions, RunFalsecolor>::Make),
                 {.synopsis = kFalsecolorSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
