// Writing of image files, and what else of an image in memory takes OpenImageIO.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pbrt/core/error.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/exr_file.h"
#include "pbrt/image/half.h"
#include "pbrt/image/image.h"
#include "pbrt/image/image_file.h"
#include "pbrt/image/image_library.h"
#include "pbrt/image/png_file.h"

namespace lacquer {

namespace {

namespace fs = std::filesystem;

// ---- Writing ----

/// Extensions and OpenImageIO's names of their formats, empty if they are written without it, in alphabetical
/// order. Other writers than these are not offered: some display images or swallow them, some (ICO in
/// version 2.4) corrupt memory.
constexpr std::pair<const char*, const char*> kKnownFormats[] = {
    {"bmp", "bmp"}, {"exr", ""}, {"gif", "gif"}, {"hdr", "hdr"},   {"jpeg", "jpeg"}, {"jpg", "jpeg"},
    {"pfm", ""},    {"png", ""}, {"ppm", "pnm"}, {"tga", "targa"}, {"tif", "tiff"},  {"tiff", "tiff"},
};

/// Null for others than those of the table.
const char* FormatOf(const std::string& extension) {
    for (const auto& [known, format] : kKnownFormats)
        if (extension == known) return format;
    return nullptr;
}

/// Whether a format of the table can be written. Asks the library of those alone that it would write.
bool IsWritable(const std::string& format) { return format.empty() || LoadImageLibrary().Writes(format); }

/// Formats whose files hold floats; all others get 8-bit values.
bool HoldsFloats(const std::string& extension) {
    return extension == "exr" || extension == "tif" || extension == "tiff" || extension == "hdr";
}

std::vector<int> AllChannels(const Image& image) {
    std::vector<int> channels(static_cast<size_t>(image.NumChannels()));
    std::iota(channels.begin(), channels.end(), 0);
    return channels;
}

/// Channels that a format takes: all of them, or the colours, or one.
std::vector<int> WrittenChannels(const Image& image, const ImageLibrary::WriterLimits& limits,
                                 const std::string& extension) {
    std::vector<int> channels = AllChannels(image);
    if (limits.holdsAnyChannels) return channels;
    const bool wantsColor = extension == "hdr" || extension == "gif";
    if (image.NumChannels() < 3) return wantsColor ? std::vector<int>{0, 0, 0} : std::vector<int>{0};
    const bool alpha = limits.holdsAlpha && image.NumChannels() >= 4 && image.Channels()[3] == "A";
    channels.resize(alpha ? 4 : 3);
    return channels;
}

/// Interleaved gradient noise [Jimenez 2014] in (-1/2, 1/2): neighbouring pixels get well-spread offsets, so
/// that rounding errors average out locally.
float Dither(int x, int y, int c) {
    const double phase = 0.06711056 * (x + 37 * c) + 0.00583715 * (y + 17 * c);
    const double value = 52.9829189 * (phase - std::floor(phase));
    return float(0.998 * (value - std::floor(value) - 0.5));
}

/// 8-bit sRGB values; alpha stays linear.
std::vector<uint8_t> EncodeBytes(const Image& image, const std::vector<int>& channels) {
    const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
    const Int2 resolution = image.Resolution();
    const ColorSpace* space = image.ColorSpace();
    const bool convert = space && space != &ColorSpace::SRGB() && channels.size() >= 3;
    std::vector<uint8_t> bytes;
    bytes.reserve(size_t(resolution.x) * size_t(resolution.y) * channels.size());
    std::vector<float> values(channels.size());
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            for (size_t i = 0; i < channels.size(); ++i) values[i] = image.Get({x, y}, channels[i]);
            if (convert) {
                const RGB rgb = ColorSpace::SRGB().ToRGB(space->ToXYZ({values[0], values[1], values[2]}));
                for (size_t i = 0; i < 3; ++i) values[i] = rgb[int(i)];
            }
            for (size_t i = 0; i < channels.size(); ++i) {
                const float v = std::isnan(values[i]) ? 0.f : std::clamp(values[i], 0.f, 1.f);
                const bool isAlpha = image.Channels()[size_t(channels[i])] == "A";
                const float code = isAlpha ? 255 * v : 255 * srgb.FromLinear(v) + Dither(x, y, int(i));
                bytes.push_back(uint8_t(std::clamp(std::floor(code + 0.5f), 0.f, 255.f)));
            }
        }
    return bytes;
}

/// The chosen channels as floats; with `half`, finite values stay finite.
std::vector<float> EncodeFloats(const Image& image, const std::vector<int>& channels, bool half) {
    std::vector<float> values;
    values.reserve(image.Pixels().size() / size_t(image.NumChannels()) * channels.size());
    std::vector<bool> isHalf;
    for (const std::string& name : image.Channels())
        isHalf.push_back(half && !image.floatChannels.contains(name));
    for (size_t i = 0; i < image.Pixels().size(); i += size_t(image.NumChannels()))
        for (int c : channels) {
            const float v = image.Pixels()[i + size_t(c)];
            const bool limit = isHalf[size_t(c)] && std::isfinite(v);
            values.push_back(limit ? std::clamp(v, -kMaxHalf, kMaxHalf) : v);
        }
    return values;
}

ImageContents ContentsOf(const Image& image, const std::vector<int>& channels, ValueType type) {
    ImageContents contents;
    contents.resolution = image.Resolution();
    contents.type = type;
    for (const int c : channels) {
        contents.channels.push_back(image.Channels()[size_t(c)]);
        const bool isFloat = image.floatChannels.contains(contents.channels.back());
        if (type == ValueType::Half && !image.floatChannels.empty())
            contents.channelTypes.push_back(isFloat ? ValueType::Float : ValueType::Half);
    }
    if (!image.dataWindow.IsEmpty()) contents.origin = image.dataWindow.min;
    contents.fullResolution = image.fullResolution;
    contents.attributes.assign(image.metadata.begin(), image.metadata.end());
    if (image.HasRGB() && image.ColorSpace() && !image.metadata.contains("chromaticities")) {
        const float* const xy = image.ColorSpace()->Chromaticities();
        contents.attributes.emplace_back("chromaticities", std::vector<float>(xy, xy + 8));
    }
    return contents;
}

using Bytes = std::vector<unsigned char>;

/// Portable float map: a line each of kind, size and byte order, then rows from the bottom. OpenImageIO 2.4
/// reads but does not write it.
Bytes EncodePfm(const Image& image) {
    const Int2 resolution = image.Resolution();
    const int channels = image.NumChannels() >= 3 ? 3 : 1;
    constexpr bool isLittle = std::endian::native == std::endian::little;
    const std::string head = fmt::format("{}\n{} {}\n{}\n", channels == 3 ? "PF" : "Pf", resolution.x,
                                         resolution.y, isLittle ? "-1.0" : "1.0");
    Bytes bytes(head.begin(), head.end());
    for (int y = resolution.y - 1; y >= 0; --y)
        for (int x = 0; x < resolution.x; ++x)
            for (int c = 0; c < channels; ++c) {
                const auto value =
                    std::bit_cast<std::array<unsigned char, sizeof(float)>>(image.Get({x, y}, c));
                bytes.insert(bytes.end(), value.begin(), value.end());
            }
    return bytes;
}

/// What OpenImageIO need not be loaded for.
Bytes EncodeHere(const Image& image, const std::string& extension, ValueType floats) {
    if (extension == "pfm") return EncodePfm(image);
    if (extension == "png") {
        const std::vector<int> channels = WrittenChannels(image, {.holdsAlpha = true}, extension);
        return EncodePng(ContentsOf(image, channels, ValueType::UInt8), EncodeBytes(image, channels).data());
    }
    const std::vector<int> channels = AllChannels(image);
    return EncodeExr(ContentsOf(image, channels, floats),
                     EncodeFloats(image, channels, floats == ValueType::Half).data());
}

Bytes EncodeByLibrary(const ImageLibrary& library, const Image& image, const std::string& extension,
                      const std::string& path, ValueType floats) {
    const std::vector<int> channels = WrittenChannels(image, library.LimitsOf(extension), extension);
    const ValueType type = HoldsFloats(extension) ? floats : ValueType::UInt8;
    const ImageContents contents = ContentsOf(image, channels, type);
    if (type == ValueType::UInt8)
        return library.Encode(contents, EncodeBytes(image, channels).data(), extension, path);
    const bool half = type == ValueType::Half;
    return library.Encode(contents, EncodeFloats(image, channels, half).data(), extension, path);
}

/// Errors: FileError about `path`.
Bytes Encode(const Image& image, const std::string& extension, const std::string& path, bool half) {
    const bool isWrittenHere = std::string_view(FormatOf(extension)).empty();
    const ImageLibrary* const library = isWrittenHere ? nullptr : &LoadImageLibrary();
    const ValueType floats = half ? ValueType::Half : ValueType::Float;
    try {
        return library ? EncodeByLibrary(*library, image, extension, path, floats)
                       : EncodeHere(image, extension, floats);
    } catch (const std::exception& e) {
        throw FileError(path, fmt::format("cannot be written: {}", OneLine(e.what())));
    }
}

// ---- Resizing ----

/// `edge` of an image `from` pixels long, where it lies when that is `to` pixels long.
int ScaledEdge(int edge, int from, int to) { return int(std::lround(double(edge) * to / from)); }

Int2 Scaled(Int2 p, Int2 from, Int2 to) {
    return {ScaledEdge(p.x, from.x, to.x), ScaledEdge(p.y, from.y, to.y)};
}

}  // namespace

Image Resize(const Image& image, Int2 resolution) {
    const Int2 from = image.Resolution();
    const int channels = image.NumChannels();
    const double bytes = double(resolution.x) * resolution.y * channels * double(sizeof(float));
    if (resolution.x < 1 || resolution.y < 1 || resolution.x > kMaxImageSide ||
        resolution.y > kMaxImageSide || bytes > double(kMaxImageBytes))
        throw std::invalid_argument(
            fmt::format("an image of {} x {} pixels is not possible; the limits are "
                        "{} pixels a side and {} MiB",
                        resolution.x, resolution.y, kMaxImageSide, kMaxImageBytes >> 20));
    Image result(resolution, image.Channels());
    const ImageLibrary& library = LoadImageLibrary();
    try {
        library.Resize({from, image.Pixels().data()}, {resolution, result.Pixels().data()}, channels,
                       "blackman-harris");
    } catch (const std::exception& e) {
        throw std::invalid_argument(OneLine(e.what()));
    }
    const Bounds2i& window = image.dataWindow;
    if (!window.IsEmpty()) {
        result.dataWindow.min = Scaled(window.min, from, resolution);
        result.dataWindow.max = result.dataWindow.min + resolution;
    }
    result.fullResolution = Scaled(image.fullResolution, from, resolution);
    result.metadata = image.metadata;
    result.format = image.format;
    result.encoding = image.encoding;
    result.SetColorSpace(image.ColorSpace());
    return result;
}

std::string ExtensionOf(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

Image ReadImage(const std::string& path, ColorEncoding encoding, const FileLoc& loc) {
    return ImageFile(path, encoding, loc).Read();
}

std::vector<std::string> WritableExtensions() {
    std::vector<std::string> extensions;
    for (const auto& [extension, format] : kKnownFormats)
        if (IsWritable(format)) extensions.emplace_back(extension);
    return extensions;
}

bool CanWriteImage(const std::string& path) {
    const char* const format = FormatOf(ExtensionOf(path));
    return format && IsWritable(format);
}

void WriteImage(const Image& image, const std::string& path, bool half) {
    const std::string extension = ExtensionOf(path);
    if (!CanWriteImage(path))
        throw FileError(path, fmt::format("there is no image format \"{}\" to write; known are {}", extension,
                                          fmt::join(WritableExtensions(), ", ")));
    const fs::path folder = fs::path(path).parent_path();
    std::error_code error;
    if (!folder.empty() && !fs::is_directory(folder, error))
        throw FileError(path, fmt::format("the folder {} does not exist", folder.string()));
    if (fs::is_directory(path, error)) throw FileError(path, "is a folder");

    const Bytes bytes = Encode(image, extension, path, half);
    OutputFile file(path);
    file.Write(bytes);
    file.Finish();
}

}  // namespace lacquer
