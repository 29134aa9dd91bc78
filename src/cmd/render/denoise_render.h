// render --denoise: what the denoiser needs of a render, and what becomes of it.
#pragma once

#include <string>
#include <vector>

#include "cmd/console.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// Auxiliary outputs that the denoiser needs.
std::vector<std::string> DenoiserAovs();
/// Denoises the colours of a developed image, and leaves out the channels of DenoiserAovs() that were not
/// asked for. Where that is not possible the colours stay as they are, with a warning; where a signal has
/// stopped the render, everything stays, for `lacquer denoise`.
/// @param aovs        outputs that were asked for
/// @param hasSplats   the image has light that was traced from the lights
void DenoiseRender(const std::vector<std::string>& aovs, bool hasSplats, Console* console, Image* image);

}  // namespace lacquer::cmd
