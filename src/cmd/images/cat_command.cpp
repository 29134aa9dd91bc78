// lacquer cat: pixels as text.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "pbrt/image/operations.h"

namespace lacquer::cmd {
namespace {

struct CatArguments {
    std::string image, crop;
    std::vector<std::string> channels;
    bool csv = false, list = false, sort = false;
};

void AddCatOptions(CLI::App& app, CatArguments& a) {
    AddImage(app, a.image);
    app.add_flag("--csv", a.csv, "Rows of the image as lines, values with commas between");
    app.add_flag("--list", a.list, "Rows as lists with brackets, as programs read them");
    app.add_flag("--sort", a.sort, "The brightest pixels last");
    app.add_option("--crop", a.crop, "x0,x1,y0,y1: only this part, in fractions or in pixels");
    AddChannels(app, a.channels);
}

std::string Values(const Image& image, Int2 p, const char* separator) {
    std::string text;
    for (int c = 0; c < image.NumChannels(); ++c)
        text += fmt::format("{}{:.9g}", c > 0 ? separator : "", image.Get(p, c));
    return text;
}

/// All pixels, rows from the top, or the darkest first.
std::vector<Int2> PixelsOf(const Image& image, bool sort) {
    std::vector<Int2> pixels;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x) pixels.emplace_back(x, y);
    if (!sort) return pixels;
    // What is no number comes first, so that the order is one.
    const auto key = [&](Int2 p) {
        const float Y = LuminanceAt(image, p);
        return std::isnan(Y) ? -Infinity : Y;
    };
    std::stable_sort(pixels.begin(), pixels.end(), [&](Int2 a, Int2 b) { return key(a) < key(b); });
    return pixels;
}

void PrintRows(const Image& image, bool isList) {
    for (int y = 0; y < image.Resolution().y; ++y) {
        std::vector<std::string> pixels;
        for (int x = 0; x < image.Resolution().x; ++x) {
            const std::string values = Values(image, {x, y}, isList ? ", " : ",");
            pixels.push_back(isList ? "[" + values + "]" : values);
        }
        const std::string line = fmt::format("{}", fmt::join(pixels, isList ? ", " : ","));
        const bool isLast = y + 1 == image.Resolution().y;
        fmt::print("{}\n", isList ? fmt::format("[{}]{}", line, isLast ? "" : ",") : line);
    }
}

ExitStatus RunCat(const CatArguments& a) {
    if (int(a.csv) + int(a.list) + int(a.sort) > 1)
        throw CLI::ValidationError("only one of --csv, --list and --sort can be given");
    const Image whole = ReadImageArgument(a.image);
    Bounds2i box{{0, 0}, whole.Resolution()};
    if (!a.crop.empty()) box = BoxOfImage("--crop", a.crop, whole).pixels;
    const Image image = whole.Part(box, ChannelsOf(whole, a.channels));
    if (a.list) fmt::print("[\n");
    if (a.csv || a.list) PrintRows(image, a.list);
    if (a.list) fmt::print("]\n");
    if (a.csv || a.list) return ExitStatus::Complete;
    const Int2 corner = image.Window().min;
    for (const Int2 p : PixelsOf(image, a.sort))
        fmt::print("({}, {}): {}\n", p.x + corner.x, p.y + corner.y, Values(image, p, " "));
    return ExitStatus::Complete;
}

constexpr const char* kCatSynopsis = "Prints the values of an image, a line for each pixel.";

}  // namespace

LACQUER_REGISTER(CommandKind, "cat", (CommandOf<CatArguments, AddCatOptions, RunCat>::Make),
                 {.synopsis = kCatSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
