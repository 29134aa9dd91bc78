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
#include "cmd/render/denoise_render.h"
#include "denoise/method.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/aov.h"

namespace lacquer::cmd {
namespace {

struct DenoiseArguments {
    std::string image, outfile, noisefile, denoiser = "nfor";
    int threads = 0;
    bool quiet = false;
};

void AddDenoiseOptions(CLI::App& app, DenoiseArguments& a) {
    AddImage(app, a.image);
    AddOutfile(app, a.outfile);
    app.add_option("--noisefile", a.noisefile,
                   "An image of the noise that is left: its standard deviation in each pixel")
        ->type_name(kFile);
    AddDenoiserOption(app, a.denoiser);
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

Image NoiseImage(const denoise::NoiseReport& noise, const Image& like) {
    Image image(like.Resolution(), {"Y"});
    image.dataWindow = like.dataWindow;
    image.fullResolution = like.fullResolution;
    for (size_t i = 0; i < image.Pixels().size(); ++i)
        image.Pixels()[i] = std::sqrt(noise.variance.All()[i][0]);
    return image;
}

ExitStatus RunDenoise(const DenoiseArguments& a) {
    Console console(ConsoleStyle::Detect(a.quiet));
    const ThreadLimit threads(a.threads);
    for (const std::string& file : {a.outfile, a.noisefile})
        if (!file.empty()) CheckImageOutput(file);
    CheckDifferent("--noisefile", a.noisefile, a.outfile);
    const denoise::Method method = denoise::MethodOf(a.denoiser);
    if (method == denoise::Method::Oidn && !a.noisefile.empty())
        throw CLI::ValidationError(
            "--noisefile: \"oidn\" does not estimate the noise that is left; \"nfor\" does");
    Image image = ReadImageArgument(a.image);
    denoise::NoiseReport noise;
    try {
        noise = denoise::DenoiseImage(method, &image, &console);
    } catch (const std::invalid_argument& e) {
        throw FileError(a.image, e.what());
    } catch (const std::runtime_error& e) {
        throw FileError(a.image, fmt::format("cannot be denoised: {}", e.what()));
    }
    // Of colours that were denoised the halves are none, and no denoiser can use them again.
    image = AovBuffer::WithoutHalves(image);
    WriteImage(image, a.outfile, image.format == PixelFormat::Half);
    if (!a.noisefile.empty()) WriteImage(NoiseImage(noise, image), a.noisefile);
    console.Info(fmt::format("{}: {}", a.outfile, NoiseInWords(noise)));
    return ExitStatus::Complete;
}

constexpr const char* kDenoiseSynopsis =
    "Removes the noise of a render that was made with --aov half,variance,albedo,normal,depth\n"
    "(albedo and normal suffice for --denoiser oidn).\n"
    "(lacquer --denoise does both in one go.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "denoise", (CommandOf<DenoiseArguments, AddDenoiseOptions, RunDenoise>::Make),
                 {.synopsis = kDenoiseSynopsis, .footer = kImageStatus});

}  // namespace lacquer::cmd
