// lacquer denoise: a render without its noise.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <stdexcept>
#include <string>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "denoise/denoiser.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/aov.h"

namespace lacquer::cmd {
namespace {

struct DenoiseArguments {
    std::string image, outfile, noisefile;
    int threads = 0;
    bool quiet = false;
};

void AddDenoiseOptions(CLI::App& app, DenoiseArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--noisefile", a.noisefile,
                   "An image of the noise that is left: its standard deviation in each pixel")
        ->type_name(kFile);
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

Image NoiseImage(const denoise::Denoised& denoised, const Image& like) {
    Image image(like.Resolution(), {"Y"});
    image.dataWindow = like.dataWindow;
    image.fullResolution = like.fullResolution;
    for (size_t i = 0; i < image.Pixels().size(); ++i)
        image.Pixels()[i] = std::sqrt(denoised.noise.All()[i][0]);
    return image;
}

ExitStatus RunDenoise(const DenoiseArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    const ThreadLimit threads(a.threads);
    for (const std::string& file : {a.outfile, a.noisefile})
        if (!file.empty()) CheckImageOutput(file);
    CheckDifferent("--noisefile", a.noisefile, a.outfile);
    Image image = ReadImageArgument(a.image);
    denoise::RenderBuffers buffers;
    try {
        buffers = denoise::BuffersOf(image);
    } catch (const std::invalid_argument& e) {
        throw FileError(a.image, e.what());
    }
    const denoise::Denoised denoised = denoise::Denoise(buffers, {.observer = &console});
    denoise::SetColors(denoised, &image);
    // Of colours that were denoised the halves are none, and no denoiser can use them again.
    image = AovBuffer::WithoutHalves(image);
    WriteImage(image, a.outfile, image.format == PixelFormat::Half);
    if (!a.noisefile.empty()) WriteImage(NoiseImage(denoised, image), a.noisefile);
    console.Info(
        fmt::format("{}: noise {:.4g}, {:.4g} before", a.outfile, denoised.noiseAfter, denoised.noiseBefore));
    return ExitStatus::Complete;
}

constexpr const char* kDenoiseSynopsis =
    "Removes the noise of a render that was made with --aov half,variance,albedo,normal,depth.\n"
    "(lacquer --denoise does both in one go.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "denoise", (CommandOf<DenoiseArguments, AddDenoiseOptions, RunDenoise>::Make),
                 {.synopsis = kDenoiseSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
