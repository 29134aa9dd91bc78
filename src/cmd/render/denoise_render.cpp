#include "cmd/render/denoise_render.h"

#include <fmt/format.h>

#include <stdexcept>

#include "cmd/choices.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::cmd {
namespace {

std::string WhyNoDenoiser(const std::string& name) {
    if (std::string why = WhyUnknown(name, denoise::MethodNames()); !why.empty()) return why;
    const std::string why = denoise::WhyUnavailable(denoise::MethodOf(name));
    return why.empty() ? why : fmt::format("\"{}\" cannot be had: {}", name, why);
}

void DenoiseColors(denoise::Method method, Console* console, Image* image) {
    try {
        console->Info(
            fmt::format("denoised: {}", NoiseInWords(denoise::DenoiseImage(method, image, console))));
    } catch (const std::invalid_argument& e) {
        console->Error(fmt::format("not denoised: the image {}", e.what()));
    } catch (const std::runtime_error& e) {
        console->Error(fmt::format("not denoised: {}", e.what()));
    }
}

}  // namespace

CLI::Option* AddDenoiserOption(CLI::App& app, std::string& name) {
    return app
        .add_option("--denoiser", name,
                    "By what: our own (nfor), or Intel Open Image Denoise (oidn) where it was built in")
        ->check(OneOf(denoise::MethodNames(), WhyNoDenoiser))
        ->capture_default_str();
}

std::string NoiseInWords(const denoise::NoiseReport& noise) {
    if (!noise.IsKnown()) return "how much noise is left is not known";
    return fmt::format("noise {:.4g}, {:.4g} before", noise.after, noise.before);
}

void CheckDenoiser(denoise::Method method, int samples, bool hasSplats) {
    if (const std::string why = denoise::WhyNot(method, samples, hasSplats); !why.empty())
        throw CLI::ValidationError(fmt::format("--denoise: the image {}", why));
}

void DenoiseRender(denoise::Method method, const std::vector<std::string>& aovs, Console* console,
                   Image* image) {
    if (Console::Signal() != 0) {
        // Whoever stops a render waits for its image, and may send a second signal that would lose it.
        console->Info("not denoised, since a signal came: lacquer denoise does it from the EXR file");
        return;
    }
    DenoiseColors(method, console, image);
    *image = WithoutAovs(*image, denoise::AovsOf(method), aovs);
}

}  // namespace lacquer::cmd
