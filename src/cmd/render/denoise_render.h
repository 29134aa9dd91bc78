// render --denoise: what the denoiser needs of a render, and what becomes of it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/console.h"
#include "denoise/method.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// `--denoiser NAME`: one of the denoisers that this build has. Returns it for more.
CLI::Option* AddDenoiserOption(CLI::App& app, std::string& name);

/// "noise 0.01, 0.1 before", or only that it is done.
std::string NoiseInWords(const denoise::NoiseReport& noise);

/// Before hours of rendering. Errors: usage, where WhyNot() knows already.
void CheckDenoiser(denoise::Method method, int samples, bool hasSplats);

/// Denoises the colours of a developed image, and leaves out the channels of AovsOf(method) that were not
/// asked for. Where that is not possible the colours stay as they are, with an error message, also for
/// --quiet; where a signal has stopped the render, everything stays, for `lacquer denoise`.
/// @param aovs  outputs that were asked for
void DenoiseRender(denoise::Method method, const std::vector<std::string>& aovs, Console* console,
                   Image* image);

}  // namespace lacquer::cmd
