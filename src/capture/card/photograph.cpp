#include "capture/card/photograph.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "pbrt/core/error.h"
#include "pbrt/core/math.h"
#include "pbrt/image/operations.h"

namespace lacquer::capture {

namespace {

/// The first of some entries that is a number above 0.
std::optional<double> PositiveNumber(const Metadata& metadata, std::initializer_list<const char*> names) {
    for (const char* name : names) {
        const auto entry = metadata.find(name);
        if (entry == metadata.end()) continue;
        const auto* asInt = std::get_if<int>(&entry->second);
        const auto* asFloat = std::get_if<float>(&entry->second);
        const double number = asInt ? *asInt : asFloat ? double(*asFloat) : 0;
        if (number > 0 && std::isfinite(number)) return number;
    }
    return {};
}

std::optional<double> ExposureOf(const Metadata& metadata) {
    const auto time = PositiveNumber(metadata, {"ExposureTime", "Exif:ExposureTime"});
    const auto iso = PositiveNumber(metadata, {"Exif:PhotographicSensitivity", "Exif:ISOSpeedRatings"});
    const auto aperture = PositiveNumber(metadata, {"FNumber", "Exif:FNumber"});
    if (!time || !iso || !aperture) return {};
    return *time * *iso / Sqr(*aperture);
}

}  // namespace

PhotographFile ReadPhotographFile(const std::string& path, Response response) {
    const ColorEncoding encoding = EncodingOf(response);
    const Image image = ReadImage(path, encoding, {path});
    const std::vector<int> colors = ColorChannels(image);
    if (colors.empty())
        throw SceneError({path}, "the image has no colours; expected R, G and B, or one channel");
    PhotographFile result;
    // Formats other than PNG were decoded as sRGB; their codes are what the response has to decode.
    const bool isRecoded = image.format == PixelFormat::Byte && image.encoding != encoding;
    const Int2 size = image.Resolution();
    result.linear = Image(size, {"R", "G", "B"});
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 3; ++c) {
                float value = image.Get({x, y}, colors[colors.size() == 3 ? size_t(c) : 0]);
                if (!std::isfinite(value))
                    throw SceneError({path},
                                     fmt::format("pixel {},{} is {}; expected finite values", x, y, value));
                if (isRecoded) value = encoding.ToLinear(image.encoding.FromLinear(value));
                result.linear.Set({x, y}, c, std::max(value, 0.F));
            }
    if (image.format == PixelFormat::Byte) result.clipped = encoding.ToLinear(254.5F / 255);
    result.focal35mm = PositiveNumber(image.metadata, {"Exif:FocalLengthIn35mmFilm"});
    result.exposure = ExposureOf(image.metadata);
    return result;
}

double FocalInPixels(double focal35mm, Int2 resolution) {
    return focal35mm * std::hypot(resolution.x, resolution.y) / std::hypot(36., 24.);
}

std::vector<std::string> PhotographsOfFolder(const std::string& folder) {
    static constexpr std::array kExtensions = {"exr", "jpeg", "jpg", "png", "tif", "tiff"};
    std::vector<std::string> paths;
    std::error_code error;
    for (std::filesystem::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
        const std::string extension = ExtensionOf(i->path().string());
        if (std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
            i->is_regular_file(error))
            paths.push_back(i->path().string());
    }
    if (error) throw FileError(folder, error.message());
    if (paths.empty()) throw FileError(folder, "has no photographs; expected files of png, jpg, exr or tif");
    std::sort(paths.begin(), paths.end());
    return paths;
}

}  // namespace lacquer::capture
