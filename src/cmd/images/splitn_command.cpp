// lacquer splitn: several images of one size side by side, in strips.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "pbrt/image/operations.h"

namespace lacquer::cmd {
namespace {

struct SplitArguments {
    std::vector<std::string> images, crops;
    std::string outfile;
    int cropSize = 96;
    bool quiet = false;
};

void AddSplitOptions(CLI::App& app, SplitArguments& a) {
    AddImageList(app, a.images, "Images of one size");
    AddOutfile(app, a.outfile);
    app.add_option("--crop", a.crops,
                   "x,y: a row below with this square of each image; may be given several times")
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--cropsize", a.cropSize, "Pixels a side of the squares")
        ->check(CLI::Range(1, kMaxImageSide))
        ->capture_default_str();
    app.add_flag("--quiet", a.quiet, "No warnings");
}

Int2 CornerOf(const std::string& text, Int2 size, int side) {
    int x = -1, y = -1, used = 0;
    if (std::sscanf(text.c_str(), "%d,%d%n", &x, &y, &used) != 2 || size_t(used) != text.size())
        BadOption("crop", text, "x,y in pixels");
    if (x < 0 || y < 0 || x + side > size.x || y + side > size.y)
        BadOption("crop", text, fmt::format("a square of {} pixels inside of {} x {}", side, size.x, size.y));
    return {x, y};
}

/// `top` with rows of squares below it, one of each image beside the other.
Image WithRows(const Image& top, const std::vector<Image>& images, const std::vector<Int2>& corners,
               int side) {
    const int width = std::max(top.Resolution().x, corners.empty() ? 0 : side * int(images.size()));
    Image result({width, top.Resolution().y + side * int(corners.size())}, top.Channels());
    result.SetColorSpace(top.ColorSpace());
    const auto copy = [&](const Image& from, Int2 corner, Int2 size, Int2 to) {
        for (int c = 0; c < result.NumChannels(); ++c) {
            const int channel = from.FindChannel(result.Channels()[size_t(c)]);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    result.Set(to + Int2(x, y), c, from.Get(corner + Int2(x, y), channel));
        }
    };
    copy(top, {0, 0}, top.Resolution(), {0, 0});
    for (size_t row = 0; row < corners.size(); ++row)
        for (size_t i = 0; i < images.size(); ++i)
            copy(images[i], corners[row], Int2(side), {int(i) * side, top.Resolution().y + int(row) * side});
    return result;
}

ExitStatus RunSplit(const SplitArguments& a) {
    if (a.images.size() < 2) throw CLI::ValidationError("splitn: at least two images are expected");
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    std::vector<Image> images;
    for (const std::string& path : a.images) {
        images.push_back(ReadImageArgument(path));
        std::string why = Mismatch(images[0], images.back());
        if (why.empty()) why = ChannelMismatch(images[0], images.back());
        WarnOfNonFinite(images.back(), path, &console);
        if (!why.empty()) throw FileError(path, fmt::format("does not fit {}: {}", a.images[0], why));
    }
    if (int(images.size()) > images[0].Resolution().x)
        throw CLI::ValidationError("splitn: there are more images than columns of pixels");
    std::vector<Int2> corners;
    for (const std::string& crop : a.crops)
        corners.push_back(CornerOf(crop, images[0].Resolution(), a.cropSize));
    WriteImage(WithRows(Strips(images), images, corners, a.cropSize), a.outfile);
    return ExitStatus::Complete;
}

constexpr const char* kSplitSynopsis =
    "Compares images of one size in one: a vertical strip of each, and squares of all of them below.";

}  // namespace

LACQUER_REGISTER(CommandKind, "splitn", (CommandOf<SplitArguments, AddSplitOptions, RunSplit>::Make),
                 {.synopsis = kSplitSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
