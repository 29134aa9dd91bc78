#include "pbrt/image/image.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "pbrt/core/check.h"

namespace lacquer {

float ColorEncoding::ToLinear(float value) const {
    switch (kind) {
        case Kind::Linear:
            return value;
        case Kind::Gamma:
            return std::pow(value, gamma);
        case Kind::SRGB:
            break;
    }
    // [IEC 61966-2-1]
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

float ColorEncoding::FromLinear(float value) const {
    value = std::clamp(value, 0.f, 1.f);
    switch (kind) {
        case Kind::Linear:
            return value;
        case Kind::Gamma:
            return std::pow(value, 1 / gamma);
        case Kind::SRGB:
            break;
    }
    return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
}

std::array<float, 256> ColorEncoding::ByteTable() const {
    std::array<float, 256> table;
    for (size_t i = 0; i < 256; ++i) table[i] = ToLinear(float(i) / 255);
    return table;
}

std::optional<ColorEncoding> ColorEncoding::Parse(const std::string& text) {
    if (text == "sRGB") return ColorEncoding{Kind::SRGB, 1};
    if (text == "linear") return ColorEncoding{Kind::Linear, 1};
    const std::string prefix = "gamma ";
    if (text.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
    char* end = nullptr;
    const float gamma = std::strtof(text.c_str() + prefix.size(), &end);
    if (end == text.c_str() + prefix.size() || *end != 0) return std::nullopt;
    if (!(gamma >= 0.01f && gamma <= 100)) return std::nullopt;
    return ColorEncoding{Kind::Gamma, gamma};
}

std::optional<WrapMode> ParseWrapMode(const std::string& text) {
    if (text == "repeat") return WrapMode::Repeat;
    if (text == "clamp") return WrapMode::Clamp;
    if (text == "black") return WrapMode::Black;
    if (text == "octahedralsphere") return WrapMode::OctahedralSphere;
    return std::nullopt;
}

Image::Image(Int2 resolution, std::vector<std::string> channels)
    : resolution_(resolution), channels_(std::move(channels)) {
    LACQUER_CHECK(resolution.x >= 0 && resolution.y >= 0);
    pixels_.resize(size_t(resolution.x) * size_t(resolution.y) * channels_.size());
}

int Image::FindChannel(const std::string& name) const {
    const auto it = std::find(channels_.begin(), channels_.end(), name);
    return it == channels_.end() ? -1 : int(it - channels_.begin());
}

bool Image::HasRGB() const {
    return NumChannels() >= 3 && channels_[0] == "R" && channels_[1] == "G" && channels_[2] == "B";
}

Image Image::WithRoomFor(const std::vector<std::string>& channels) const {
    std::vector<std::string> names = channels_;
    names.insert(names.end(), channels.begin(), channels.end());
    Image result(resolution_, std::move(names));
    const size_t before = channels_.size(), after = result.channels_.size();
    for (size_t in = 0, out = 0; in < pixels_.size(); in += before, out += after)
        std::copy_n(&pixels_[in], before, &result.pixels_[out]);
    result.dataWindow = dataWindow;
    result.fullResolution = fullResolution;
    result.metadata = metadata;
    result.floatChannels = floatChannels;
    result.format = format;
    result.encoding = encoding;
    result.colorSpace_ = colorSpace_;
    return result;
}

Image Image::WithChannel(const std::string& name, const std::vector<float>& values) const {
    LACQUER_CHECK(values.size() * channels_.size() == pixels_.size());
    Image result = WithRoomFor({name});
    const size_t last = channels_.size();
    for (size_t i = 0; i < values.size(); ++i) result.pixels_[i * (last + 1) + last] = values[i];
    return result;
}

Image Image::Part(const Bounds2i& pixels, const std::vector<int>& channels) const {
    LACQUER_CHECK(!pixels.IsEmpty() && pixels.Intersect({{0, 0}, resolution_}) == pixels);
    std::vector<std::string> names;
    for (const int c : channels) names.push_back(channels_.at(size_t(c)));
    Image part({pixels.Width(), pixels.Height()}, std::move(names));
    for (int y = 0; y < pixels.Height(); ++y)
        for (int x = 0; x < pixels.Width(); ++x)
            for (size_t c = 0; c < channels.size(); ++c)
                part.Set({x, y}, int(c), Get(Int2(x, y) + pixels.min, channels[c]));
    const Int2 corner = Window().min;
    part.dataWindow = {pixels.min + corner, pixels.max + corner};
    part.fullResolution = FrameResolution();
    part.metadata = metadata;
    for (const std::string& name : part.channels_)
        if (floatChannels.contains(name)) part.floatChannels.insert(name);
    part.format = format;
    part.encoding = encoding;
    part.colorSpace_ = colorSpace_;
    return part;
}

Image Image::OnlyChannels(const std::function<bool(const std::string&)>& isKept) const {
    std::vector<int> kept;
    for (int c = 0; c < NumChannels(); ++c)
        if (isKept(channels_[size_t(c)])) kept.push_back(c);
    return Part({{0, 0}, resolution_}, kept);
}

void Image::RenameChannels(std::vector<std::string> names) {
    LACQUER_CHECK(names.size() == channels_.size());
    channels_ = std::move(names);
}

bool Image::HasNonFinite() const {
    return std::any_of(pixels_.begin(), pixels_.end(), [](float v) { return !std::isfinite(v); });
}

bool WrapPixel(Int2* p, Int2 resolution, WrapMode wrap) {
    if (p->x >= 0 && p->y >= 0 && p->x < resolution.x && p->y < resolution.y) return true;
    switch (wrap) {
        case WrapMode::Black:
            return false;
        case WrapMode::Repeat:
            *p = {Mod(p->x, resolution.x), Mod(p->y, resolution.y)};
            return true;
        case WrapMode::Clamp:
            break;
        case WrapMode::OctahedralSphere:
            // Across an edge of the square, the octahedral map continues mirrored along that edge.
            if (p->x < 0 || p->x >= resolution.x) {
                p->x = p->x < 0 ? -1 - p->x : 2 * resolution.x - 1 - p->x;
                p->y = resolution.y - 1 - p->y;
            }
            if (p->y < 0 || p->y >= resolution.y) {
                p->x = resolution.x - 1 - p->x;
                p->y = p->y < 0 ? -1 - p->y : 2 * resolution.y - 1 - p->y;
            }
            break;
    }
    *p = glm::clamp(*p, Int2(0), resolution - 1);
    return true;
}

float Image::GetWrapped(Int2 p, int c, WrapMode wrap) const {
    return WrapPixel(&p, resolution_, wrap) ? Get(p, c) : 0.f;
}

float Image::Bilinear(Point2 st, int c, WrapMode wrap) const {
    if (!std::isfinite(st.x) || !std::isfinite(st.y)) return 0;
    st = WrapCoordinates(st, wrap);
    const float x = st.x * float(resolution_.x) - 0.5f, y = st.y * float(resolution_.y) - 0.5f;
    const int xi = int(std::floor(x)), yi = int(std::floor(y));
    const float dx = x - float(xi), dy = y - float(yi);
    return Lerp(dy, Lerp(dx, GetWrapped({xi, yi}, c, wrap), GetWrapped({xi + 1, yi}, c, wrap)),
                Lerp(dx, GetWrapped({xi, yi + 1}, c, wrap), GetWrapped({xi + 1, yi + 1}, c, wrap)));
}

}  // namespace lacquer
