// lacquer assemble: crops of one image become the whole.
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

struct AssembleArguments {
    std::vector<std::string> images;
    std::string outfile;
    bool quiet = false;
};

void AddAssembleOptions(CLI::App& app, AssembleArguments& a) {
    AddImageList(app, a.images, "Crops of one image, which know their place (EXR)");
    AddOutfile(app, a.outfile);
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

ExitStatus RunAssemble(const AssembleArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    CheckImageOutput(a.outfile);
    std::vector<Image> parts;
    for (const std::string& path : a.images) {
        Image part = ReadImageArgument(path);
        WarnOfNonFinite(part, path, &console);
        if (!parts.empty()) {
            const Image& first = parts[0];
            std::string why = ChannelMismatch(first, part);
            if (part.FrameResolution() != first.FrameResolution())
                why = fmt::format("its whole frame has {} x {} pixels, not {} x {}", part.FrameResolution().x,
                                  part.FrameResolution().y, first.FrameResolution().x,
                                  first.FrameResolution().y);
            if (part.HasRGB() && part.ColorSpace() != first.ColorSpace())
                why = "its colours are in another colour space";
            if (!why.empty())
                throw FileError(path, fmt::format("cannot be put together with {}: {}", a.images[0], why));
        }
        parts.push_back(std::move(part));
    }
    const Assembly result = Assemble(parts);
    if (result.missing > 0)
        console.Warn(fmt::format("{}: {} pixels are in no image, and black", a.outfile, result.missing));
    if (result.overlapping > 0)
        console.Warn(fmt::format("{}: {} pixels are in several images; the last one counts", a.outfile,
                                 result.overlapping));
    WriteImage(result.image, a.outfile, result.image.format == PixelFormat::Half);
    console.Info(fmt::format("{}: {} images", a.outfile, parts.size()));
    return ExitStatus::Complete;
}

constexpr const char* kAssembleSynopsis = "Pastes crops of one image into the whole, by their data windows.";

}  // namespace

LACQUER_REGISTER(CommandKind, "assemble",
                 (CommandOf<AssembleArguments, AddAssembleOptions, RunAssemble>::Make),
                 {.synopsis = kAssembleSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
