// PNG files byte by byte, of all kinds and with anything wrong that a test wants.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace lacquer::png_bytes {

inline std::string Number(uint32_t n) { return {char(n >> 24), char(n >> 16), char(n >> 8), char(n)}; }

inline std::string Chunk(const std::string& name, const std::string& data) {
    const std::string body = name + data;
    const uLong checksum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()));
    return Number(uint32_t(data.size())) + body + Number(uint32_t(checksum));
}

inline std::string Zipped(const std::string& bytes) {
    uLongf size = compressBound(uLong(bytes.size()));
    std::string zipped(size, '\0');
    compress(reinterpret_cast<Bytef*>(zipped.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
             uLong(bytes.size()));
    zipped.resize(size);
    return zipped;
}

struct Png {
    uint32_t width = 3, height = 3;
    char bits = 8, type = 2, compression = 0, filter = 0, interlace = 0;
    std::string palette = {};
    std::string rows = {};  // all pixels, with their filters

    std::string Header() const {
        return Chunk(
            "IHDR", Number(width) + Number(height) + std::string{bits, type, compression, filter, interlace});
    }
    std::string File(const std::string& pixels) const {
        const std::string plte = palette.empty() ? "" : Chunk("PLTE", palette);
        return "\x89PNG\r\n\x1a\n" + Header() + plte + pixels + Chunk("IEND", "");
    }
    std::string File() const { return File(Chunk("IDAT", Zipped(rows))); }
};

/// Bytes of all rows with their filters, by counting pixels pass by pass.
inline size_t NumRowBytes(uint32_t width, uint32_t height, int bitsPerPixel, bool isInterlaced) {
    // The pass of each pixel in a block of 8 x 8.
    constexpr const char* kPasses[8] = {"16462646", "77777777", "56565656", "77777777",
                                        "36463646", "77777777", "56565656", "77777777"};
    size_t bytes = 0;
    for (char pass = '1'; pass <= '7'; ++pass)
        for (uint32_t y = 0; y < height; ++y) {
            size_t pixels = 0;
            for (uint32_t x = 0; x < width; ++x) pixels += !isInterlaced || kPasses[y % 8][x % 8] == pass;
            if (pixels > 0 && (isInterlaced || pass == '1'))
                bytes += 1 + (pixels * size_t(bitsPerPixel) + 7) / 8;
        }
    return bytes;
}

}  // namespace lacquer::png_bytes
