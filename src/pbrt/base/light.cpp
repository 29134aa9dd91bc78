#include "pbrt/base/light.h"

#include <fmt/format.h>

#include "pbrt/core/spectrum.h"

namespace lacquer {

namespace {

/// Colour space of the rgb parameter `name`: the one in force where it stands.
const ColorSpace& SpaceOf(const Params& params, std::string_view name) {
    const ColorSpace* space = &params.ColorSpace();
    for (const Parameter& p : params.All())
        if (p.type == "rgb" && p.name == name && p.colorSpace) space = p.colorSpace;
    return *space;
}

}  // namespace

float EmissionScale(const Spectrum& emission, const Params& params, std::string_view parameter, float scale) {
    // Colours are scaled by their white, which every colour space has with this integral.
    const float luminance = params.GetRgb(parameter) ? kCieYIntegral : InnerProduct(emission, CieY());
    const float factor = scale / luminance;
    if (!(luminance > 0) || !std::isfinite(luminance) || !std::isfinite(factor))
        params.Fail(parameter,
                    fmt::format("an emission spectrum must have a finite luminance above zero to be scaled "
                                "to, but its integral with the luminous efficiency is {}",
                                luminance));
    return factor;
}

float EmissionLuminance(const Params& params, std::string_view parameter) {
    const std::optional<RGB> rgb = params.GetRgb(parameter);
    return rgb ? SpaceOf(params, parameter).Luminance(*rgb) : 1.f;
}

}  // namespace lacquer
