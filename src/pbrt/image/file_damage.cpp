#include "pbrt/image/file_damage.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>

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

/// OpenEXR reserves as much memory as an attribute of the header claims to need before it finds that the file
/// is shorter.
std::string ExrDamage(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const int64_t end = int64_t(file.tellg());
    const char* const tooShort = "the EXR header ends too early";
    file.seekg(4);
    unsigned char version[4], size[4];
    if (!file.read(reinterpret_cast<char*>(version), 4)) return tooShort;
    const bool isMultipart = version[1] & 0x10;
    std::string name, type;
    // Each header ends with an empty name; several headers end with an empty one.
    for (bool headerIsEmpty = true; std::getline(file, name, '\0'); headerIsEmpty = name.empty()) {
        if (name.empty() && (!isMultipart || headerIsEmpty)) return "";
        if (name.empty()) continue;
        if (!std::getline(file, type, '\0') || !file.read(reinterpret_cast<char*>(size), 4)) return tooShort;
        const uint32_t bytes =
            size[0] | (uint32_t(size[1]) << 8) | (uint32_t(size[2]) << 16) | (uint32_t(size[3]) << 24);
        if (int64_t(file.tellg()) + int64_t(bytes) > end)
            return "an attribute of the EXR header is larger than the file";
        file.seekg(int64_t(bytes), std::ios::cur);
    }
    return tooShort;
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
    if (format == "openexr") return ExrDamage(path);
    if (format == "gif") return GifDamage(path);
    return "";
}

std::string PixelDamage(const std::string& path, const std::string& format) {
    return format == "png" ? PngPixelDamage(path) : "";
}

}  // namespace lacquer
