#include "cmd/gaussfit/images.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>

#include "cmd/page_parts.h"

namespace lacquer::cmd {

namespace {

void AppendBigEndian(uint32_t value, std::string* out) {
    for (int shift = 24; shift >= 0; shift -= 8) *out += char((value >> shift) & 0xff);
}

/// A chunk of a PNG file: length, name, data, checksum of name and data.
void AppendChunk(const std::string& name, const std::string& data, std::string* out) {
    AppendBigEndian(uint32_t(data.size()), out);
    const std::string body = name + data;
    *out += body;
    AppendBigEndian(uint32_t(crc32(0, reinterpret_cast<const Bytef*>(body.data()), uInt(body.size()))), out);
}

}  // namespace

std::array<uint8_t, 3> ColorOf(double value) {
    constexpr std::array<std::array<double, 3>, 5> kStops = {
        {{15, 18, 42}, {45, 61, 120}, {42, 126, 142}, {122, 194, 116}, {250, 240, 160}}};
    const double position = std::clamp(value, 0.0, 1.0) * double(kStops.size() - 1);
    const size_t i = std::min(size_t(position), kStops.size() - 2);
    std::array<uint8_t, 3> color{};
    for (size_t c = 0; c < 3; ++c) {
        const double t = position - double(i);
        color[c] = uint8_t(std::lround((1 - t) * kStops[i][c] + t * kStops[i + 1][c]));
    }
    return color;
}

void ColorImage::SetValue(int x, int y, double value) {
    const std::array<uint8_t, 3> color =
        std::isnan(value) ? std::array<uint8_t, 3>{128, 128, 128} : ColorOf(value);
    std::copy(color.begin(), color.end(), bytes_.begin() + (ptrdiff_t(y) * width_ + x) * 3);
}

std::string ColorImage::DataUri() const {
    std::string header;
    AppendBigEndian(uint32_t(width_), &header);
    AppendBigEndian(uint32_t(height_), &header);
    header += std::string("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB, no interlacing
    std::string rows;
    for (int y = 0; y < height_; ++y) {
        rows += '\0';  // this row is stored as it is
        const auto begin = bytes_.begin() + ptrdiff_t(y) * width_ * 3;
        rows.append(begin, begin + ptrdiff_t(width_) * 3);
    }
    std::string png("\x89PNG\r\n\x1a\n", 8);
    AppendChunk("IHDR", header, &png);
    AppendChunk("IDAT", Deflated(rows), &png);
    AppendChunk("IEND", "", &png);
    return "data:image/png;base64," + ToBase64(png);
}

}  // namespace lacquer::cmd
