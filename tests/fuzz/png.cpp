// PNG files, as all images are read.
#include <zlib.h>

#include <algorithm>

#include "fuzz/fuzz_target.h"
#include "pbrt/image/image.h"

namespace lacquer::fuzz {
namespace {

// The checksums of all chunks made right, which no mutation does.
std::string WithChecksums(std::string_view bytes) {
    constexpr size_t kSignature = 8, kBefore = 8, kBehind = 4;
    std::string png(bytes);
    for (size_t at = kSignature; at + kBefore + kBehind <= png.size();) {
        const auto* byte = reinterpret_cast<const unsigned char*>(png.data()) + at;
        const size_t length = size_t(byte[0]) << 24 | size_t(byte[1]) << 16 | size_t(byte[2]) << 8 | byte[3];
        if (length > png.size() - at - kBefore - kBehind) break;
        const uLong checksum = crc32_z(crc32_z(0, nullptr, 0), byte + 4, length + 4);
        for (size_t i = 0; i < 4; ++i) png[at + kBefore + length + i] = char(checksum >> (24 - 8 * i) & 255);
        at += kBefore + length + kBehind;
    }
    return png;
}

void Png(std::string_view bytes) {
    const InputFile file(WithChecksums(bytes));
    const Image linear = ReadImage(file.Path(), {ColorEncoding::Kind::Linear, 1}, {});
    const Image srgb = ReadImage(file.Path(), {ColorEncoding::Kind::SRGB, 1}, {});
    Require(linear.Resolution() == srgb.Resolution(), "the encoding changes no size");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "png", Png);

}  // namespace lacquer::fuzz
