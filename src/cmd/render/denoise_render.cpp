#include "cmd/render/denoise_render.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "denoise/denoiser.h"
#include "pbrt/film/aov.h"

namespace lacquer::cmd {
namespace {

void DenoiseColors(bool hasSplats, Console* console, Image* image) {
    try {
        if (hasSplats)
            throw std::invalid_argument("has light that was traced from the lights, which has no halves");
        const denoise::Denoised denoised =
            denoise::Denoise(denoise::BuffersOf(*image), {.observer = console});
        denoise::SetColors(denoised, image);
        console->Info(
            fmt::format("denoised: noise {:.4g}, {:.4g} before", denoised.noiseAfter, denoised.noiseBefore));
    } catch (const std::invalid_argument& e) {
        console->Warn(fmt::format("not denoised: the image {}", e.what()));
    }
}

}  // namespace

std::vector<std::string> DenoiserAovs() { return {"half", "variance", "albedo", "normal", "depth"}; }

void DenoiseRender(const std::vector<std::string>& aovs, bool hasSplats, Console* console, Image* image) {
    if (Console::Signal() != 0) {
        // Whoever stops a render waits for its image, and may send a second signal that would lose it.
        console->Info("not denoised, since a signal came: lacquer denoise does it from the EXR file");
        return;
    }
    DenoiseColors(hasSplats, console, image);
    std::vector<std::string> helpers = AovBuffer::ChannelsOf(DenoiserAovs());
    for (const std::string& channel : AovBuffer::ChannelsOf(aovs)) std::erase(helpers, channel);
    *image = image->OnlyChannels([&](const std::string& channel) {
        return std::find(helpers.begin(), helpers.end(), channel) == helpers.end();
    });
}

}  // namespace lacquer::cmd
