#include "pbrt/image/file_damage.h"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <vector>

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

/// What is wrong with the chunks of a PNG file: truncation or a wrong checksum in what must be understood.
/// Empty if nothing is. libpng would find the same, and print it.
std::string PngDamage(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    file.seekg(8);
    std::vector<unsigned char> buffer(1 << 16);
    const auto number = [&] {
        return (uint32_t(buffer[0]) << 24) | (uint32_t(buffer[1]) << 16) | (uint32_t(buffer[2]) << 8) |
               buffer[3];
    };
    const auto read = [&](size_t count) {
        return bool(file.read(reinterpret_cast<char*>(buffer.data()), std::streamsize(count)));
    };
    while (true) {
        if (!read(4)) return "the PNG data end too early";
        uint32_t left = number();
        if (!read(4)) return "the PNG data end too early";
        const std::string name(buffer.begin(), buffer.begin() + 4);
        uLong checksum = crc32(0, buffer.data(), 4);
        while (left > 0) {
            const uint32_t count = std::min(left, uint32_t(buffer.size()));
            if (!read(count)) return "the PNG data end too early";
            checksum = crc32(checksum, buffer.data(), count);
            left -= count;
        }
        if (!read(4)) return "the PNG data end too early";
        const bool isCritical = std::isupper(static_cast<unsigned char>(name[0])) ||
                                !std::isalpha(static_cast<unsigned char>(name[0]));
        if (isCritical && checksum != number()) return "a PNG chunk has a wrong checksum";
        if (name == "IEND") return "";
    }
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

}  // namespace

std::string FileDamage(const std::string& path, const std::string& format) {
    if (format == "png") return PngDamage(path);
    if (format == "jpeg") return JpegDamage(path);
    if (format == "openexr") return ExrDamage(path);
    return "";
}

}  // namespace lacquer
