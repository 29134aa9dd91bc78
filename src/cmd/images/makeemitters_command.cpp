// lacquer makeemitters: an image as a wall of lights.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"

namespace lacquer::cmd {
namespace {

struct MakeEmittersArguments {
    std::string image;
    int downsample = 1;
};

void AddMakeEmittersOptions(CLI::App& app, MakeEmittersArguments& a) {
    AddImage(app, a.image);
    app.add_option("--downsample", a.downsample, "Pixels of the image on a side of one light")
        ->check(CLI::Range(1, kMaxImageSide))
        ->capture_default_str();
}

/// The mean colours of squares; what is left at the far edges are smaller ones.
Image Averaged(const Image& image, int side) {
    const Int2 from = image.Resolution(), to = (from + side - 1) / side;
    Image result(to, {"R", "G", "B"});
    for (int y = 0; y < to.y; ++y)
        for (int x = 0; x < to.x; ++x) {
            const Int2 begin = Int2(x, y) * side, end = glm::min(begin + side, from);
            RGB sum(0);
            for (int v = begin.y; v < end.y; ++v)
                for (int u = begin.x; u < end.x; ++u)
                    sum += RGB(image.Get({u, v}, 0), image.Get({u, v}, 1), image.Get({u, v}, 2));
            sum /= float((end.x - begin.x) * (end.y - begin.y));
            for (int c = 0; c < 3; ++c) result.Set({x, y}, c, sum[c]);
        }
    return result;
}

ExitStatus RunMakeEmitters(const MakeEmittersArguments& a) {
    Console console(ConsoleStyle::Detect(false));
    Image image = ReadImageArgument(a.image);
    if (!image.HasRGB()) throw FileError(a.image, "lights need the channels R, G and B");
    WarnOfNonFinite(image, a.image, &console);
    image = Averaged(image, a.downsample);
    const Int2 size = image.Resolution();
    fmt::print("# {} as {} x {} lights in the square of the longer side 1, upright in the plane z = 0\n",
               a.image, size.x, size.y);
    const float step = 1 / float(std::max(size.x, size.y));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const RGB rgb(image.Get({x, y}, 0), image.Get({x, y}, 1), image.Get({x, y}, 2));
            if (!(std::max({rgb.x, rgb.y, rgb.z}) > 0)) continue;
            const float x0 = float(x) * step, x1 = x0 + step;
            const float y1 = float(size.y - y) * step, y0 = y1 - step;
            fmt::print(
                "AttributeBegin\n    AreaLightSource \"diffuse\" \"rgb L\" [{:.6g} {:.6g} {:.6g}]\n"
                "    Shape \"bilinearmesh\" \"point3 P\" [{:.6g} {:.6g} 0  {:.6g} {:.6g} 0  {:.6g} {:.6g} 0  "
                "{:.6g} {:.6g} 0]\nAttributeEnd\n",
                std::max(rgb.x, 0.f), std::max(rgb.y, 0.f), std::max(rgb.z, 0.f), x0, y0, x1, y0, x0, y1, x1,
                y1);
        }
    return ExitStatus::Complete;
}

constexpr const char* kMakeEmittersSynopsis =
    "Prints a scene fragment: a quadrilateral that emits for each pixel.";

}  // namespace

LACQUER_REGISTER(CommandKind, "makeemitters",
                 (CommandOf<MakeEmittersArguments, AddMakeEmittersOptions, RunMakeEmitters>::Make),
                 {.synopsis = kMakeEmittersSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
