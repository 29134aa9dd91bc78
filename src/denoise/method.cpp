#include "denoise/method.h"

#include <fmt/format.h>

#include <stdexcept>

#include "denoise/denoiser.h"
#include "denoise/oidn.h"
#include "pbrt/core/parallel.h"

namespace lacquer::denoise {
namespace {

/// Three channels as they are.
Color ChannelsOf(const Image& image, const char* const (&names)[3]) {
    int channels[3];
    for (int c = 0; c < 3; ++c) {
        channels[c] = image.FindChannel(names[c]);
        if (channels[c] < 0)
            throw std::invalid_argument(fmt::format(
                "has no channel {}; render with --denoise --denoiser oidn, or with --aov albedo,normal",
                names[c]));
    }
    const Int2 size = image.Resolution();
    Color result(size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (size_t c = 0; c < 3; ++c) result.At(x, y)[c] = image.Get({x, y}, channels[c]);
    return result;
}

NoiseReport ByNfor(Image* image, Observer* observer) {
    Denoised denoised = Denoise(BuffersOf(*image), {.observer = observer});
    SetColors(denoised.color, image);
    return {std::move(denoised.noise), denoised.noiseBefore, denoised.noiseAfter};
}

NoiseReport ByOidn(Image* image, Observer* observer) {
    if (!image->HasRGB()) throw std::invalid_argument("has no channels R, G and B");
    if (image->HasNonFinite()) throw std::invalid_argument("has values that are NaN or infinite");
    const Color color = ChannelsOf(*image, {"R", "G", "B"});
    const Color albedo = ChannelsOf(*image, {"Albedo.R", "Albedo.G", "Albedo.B"});
    const Color normal = ChannelsOf(*image, {"Ns.X", "Ns.Y", "Ns.Z"});
    SetColors(FilterByOidn(color, albedo, normal, MaxThreads(), observer), image);
    return {};
}

}  // namespace

std::vector<std::string> MethodNames() { return {"nfor", "oidn"}; }

Method MethodOf(const std::string& name) { return name == "oidn" ? Method::Oidn : Method::Nfor; }

std::string WhyUnavailable(Method method) {
    if (method != Method::Oidn || HasOidn()) return {};
    return "Intel Open Image Denoise was not found when Lacquer was built (docs/denoise.md); \"nfor\" is "
           "always there";
}

std::vector<std::string> AovsOf(Method method) {
    if (method == Method::Oidn) return {"albedo", "normal"};
    return {"half", "variance", "albedo", "normal", "depth"};
}

std::vector<std::string> WithAovsOf(Method method, std::vector<std::string> aovs) {
    const std::vector<std::string> more = AovsOf(method);
    aovs.insert(aovs.end(), more.begin(), more.end());
    return aovs;
}

std::string WhyNot(Method method, int samples, bool hasSplats) {
    if (method == Method::Oidn) return {};
    if (hasSplats) return "has light that is traced from the lights, which has no halves";
    if (samples < 2) return "has one sample in each pixel, and at least two are needed";
    return {};
}

NoiseReport DenoiseImage(Method method, Image* image, Observer* observer) {
    return method == Method::Oidn ? ByOidn(image, observer) : ByNfor(image, observer);
}

}  // namespace lacquer::denoise
