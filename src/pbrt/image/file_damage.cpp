#include "pbrt/image/file_damage.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <iterator>

#include "pbrt/image/exr_damage.h"
#include "pbrt/image/image.h"
#include "pbrt/image/png_damage.h"

namespace lacquer {

namespace {

/// Decoders fill the missing part of a truncated file with grey and call it a success.
std::string JpegDamage(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    // Neither marker can occur inside compressed data, so the last scan must be followed by an end of image.
    const size_t scan = bytes.rfind("\xff\xda");
    const bool complete = scan != std::string::npos && bytes.find("\xff\xd9", scan) != std::string::npos;
    return complete ? "" : "the JPEG data end too early";
}

/// OpenImageIO makes the canvas, of four bytes a pixel, when it opens the file: 17 GB for ten bytes.
std::string GifDamage(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<unsigned char, 10> head{};
    if (!file.read(reinterpret_cast<char*>(head.data()), head.size())) return "the GIF header ends too early";
    const int width = head[6] | head[7] << 8, height = head[8] | head[9] << 8;
    constexpr size_t kMaxPixels = kMaxImageBytes / (4 * sizeof(float));
    if (size_t(width) * size_t(height) <= kMaxPixels) return "";
    return fmt::format("the GIF header claims {} x {} pixels; the limit is {} in all", width, height,
                       kMaxPixels);
}

}  // namespace

std::string FileDamage(const std::string& path, const std::string& format) {
    if (format == "png") return PngChunkDamage(path);
    if (format == "jpeg") return JpegDamage(path);
    if (format == "openexr") return ExrHeaderDamage(path);
    if (format == "gif") return GifDamage(path);
    return "";
}

std::string PixelDamage(const std::string& path, const std::string& format) {
    return format == "png" ? PngPixelDamage(path) : "";
}

}  // namespace lacquer
