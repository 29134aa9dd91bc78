#include "cmd/page_parts.h"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "cmd/command_support.h"
#include "pbrt/image/half.h"

namespace lacquer::cmd {

namespace {

/// Finite values stay finite.
uint16_t ToPageHalf(float value) {
    return FloatToHalf(std::isfinite(value) ? std::clamp(value, -kMaxHalf, kMaxHalf) : value);
}

/// From the image's RGB to linear sRGB.
glm::mat3 ToLinearSRGB(const Image& image) {
    const ColorSpace* space = image.ColorSpace();
    if (!space || space == &ColorSpace::SRGB()) return glm::mat3(1);
    return ColorSpace::SRGB().RGBFromXYZ() * space->XYZFromRGB();
}

}  // namespace

std::string Sentence(std::string message) {
    if (!message.empty()) message[0] = char(std::toupper(static_cast<unsigned char>(message[0])));
    return message + ".";
}

std::string EscapeHtml(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string JsonForPage(const nlohmann::ordered_json& value) {
    const std::string json = JsonText(value);
    std::string out;
    out.reserve(json.size());
    for (size_t i = 0; i < json.size(); ++i) {
        // These stand in strings only, where JSON knows them by their numbers too.
        if (json[i] == '<')
            out += "\\u003c";
        else if (json[i] == '>')
            out += "\\u003e";
        else if (json[i] == '&')
            out += "\\u0026";
        else if (json.compare(i, 3, "\xe2\x80\xa8") == 0)
            out += "\\u2028", i += 2;
        else if (json.compare(i, 3, "\xe2\x80\xa9") == 0)
            out += "\\u2029", i += 2;
        else
            out += json[i];
    }
    return out;
}

std::string ToBase64(std::string_view bytes) {
    constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t count = std::min<size_t>(3, bytes.size() - i);
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? uint8_t(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k) out += k <= count ? kLetters[(group >> (18 - 6 * k)) & 63] : '=';
    }
    return out;
}

std::string Deflated(std::string_view bytes) {
    uLongf size = compressBound(uLong(bytes.size()));
    std::string out(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                  uLong(bytes.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
        throw std::runtime_error("an image could not be compressed");
    out.resize(size);
    return out;
}

int NumPageChannels(const Image& image) { return image.HasRGB() ? 3 : 1; }

std::string PixelsForPage(const Image& image) {
    const Int2 resolution = image.Resolution();
    const size_t numPixels = size_t(resolution.x) * size_t(resolution.y);
    const auto numChannels = size_t(NumPageChannels(image));
    const size_t numValues = numPixels * numChannels;
    const glm::mat3 toLinearSRGB = ToLinearSRGB(image);
    const bool converts = numChannels == 3 && toLinearSRGB != glm::mat3(1);
    std::string out(2 * numValues, '\0');
    for (size_t i = 0; i < numPixels; ++i) {
        const float* pixel = image.Pixels().data() + i * size_t(image.NumChannels());
        Vec3 value(pixel[0]);
        if (numChannels == 3) value = Vec3(pixel[0], pixel[1], pixel[2]);
        // Without need no product: it would spread one channel's infinity over all.
        if (converts) value = toLinearSRGB * value;
        for (size_t c = 0; c < numChannels; ++c) {
            const uint16_t half = ToPageHalf(value[int(c)]);
            out[c * numPixels + i] = char(half >> 8);
            out[numValues + c * numPixels + i] = char(half & 0xff);
        }
    }
    return out;
}

}  // namespace lacquer::cmd
