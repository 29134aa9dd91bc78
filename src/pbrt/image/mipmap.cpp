#include "pbrt/image/mipmap.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "pbrt/image/half.h"
#include "pbrt/image/pyramid.h"
#include "pbrt/image/texture_source.h"
#include "pbrt/image/tile_cache.h"

namespace lacquer {

namespace {

/// Weights of a Gaussian that ends at radius 1, by squared radius in steps of 1/128.
constexpr int kEwaTableSize = 128;
const std::array<float, kEwaTableSize> kEwaTable = [] {
    std::array<float, kEwaTableSize> values;
    constexpr float alpha = 2;
    for (size_t i = 0; i < kEwaTableSize; ++i)
        values[i] = std::exp(-alpha * float(i) / (kEwaTableSize - 1)) - std::exp(-alpha);
    return values;
}();

/// Floor of the logarithm of a positive number; of zero, some number below -126.
int FloorLog2(float x) { return int(std::bit_cast<uint32_t>(x) >> 23) - 127; }

template <class V>
V Load(const uint8_t* bytes) {
    V value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// Rows that one image holds, as a source of its pyramid.
class ImageSource final : public PyramidSource {
  public:
    ImageSource(const Image& image, std::vector<int> channels)
        : image_(image), channels_(std::move(channels)) {
        row_.resize(size_t(image.Resolution().x) * channels_.size());
    }
    Int2 Resolution() const override { return image_.Resolution(); }
    int NumChannels() const override { return int(channels_.size()); }
    const float* Row(int y) override {
        float* out = row_.data();
        for (int x = 0; x < image_.Resolution().x; ++x)
            for (const int c : channels_) *out++ = image_.Get({x, y}, c);
        return row_.data();
    }
    float EdgeValue(Int2 p, int channel) const override { return image_.Get(p, channels_[size_t(channel)]); }
    float Lowest() const override {
        return *std::min_element(image_.Pixels().begin(), image_.Pixels().end());
    }

  private:
    const Image& image_;
    std::vector<int> channels_;
    std::vector<float> row_;
};

}  // namespace

MipMap::MipMap() = default;
MipMap::MipMap(MipMap&&) noexcept = default;
MipMap& MipMap::operator=(MipMap&&) noexcept = default;
MipMap::~MipMap() = default;

MipMap::Level::Level(Int2 sides)
    : resolution(sides),
      size(sides),
      widthBits(std::countr_zero(uint32_t(sides.x))),
      tileBits(std::min({3, widthBits, std::countr_zero(uint32_t(sides.y))})) {}

/// Rows of a pyramid that stays in memory.
class MipMap::LevelSink final : public PyramidSink {
  public:
    LevelSink(MipMap& map, size_t texelBytes) : map_(map), texelBytes_(texelBytes) {
        for (Level& level : map.levels_) {
            level.bytes = size_t(level.resolution.x) * size_t(level.resolution.y) * texelBytes;
            level.texels.reset(static_cast<uint8_t*>(::operator new[](level.bytes, kCacheLine)));
        }
    }
    void TakeRow(int level, int y, const uint8_t* texels) override {
        Level& l = map_.levels_[size_t(level)];
        const int run = 1 << l.tileBits;
        for (int x = 0; x < l.resolution.x; x += run)
            std::memcpy(&l.texels[l.IndexOf({x, y}) * texelBytes_], texels + size_t(x) * texelBytes_,
                        size_t(run) * texelBytes_);
    }

  private:
    MipMap& map_;
    size_t texelBytes_;
};

MipMap MipMap::Make(const Image& image, WrapMode wrap, const std::string& path, const FileLoc& loc) {
    TextureSurvey survey(image.Channels());
    survey.AddPixels(image.Pixels().data(), image.Pixels().size() / size_t(image.NumChannels()));
    const std::vector<int> channels = survey.UsedChannels(path, loc);
    const TexelFormat format{image.format, image.encoding, int(channels.size())};
    const Int2 resolution = PyramidLevels(image.Resolution())[0];
    const size_t bytes = size_t(resolution.x) * size_t(resolution.y) * format.TexelBytes();
    if (bytes > kMaxImageBytes)
        throw SceneError(
            loc, fmt::format("{}: the image takes {} MiB once its sides are powers of two; the limit is {}",
                             path, bytes >> 20, kMaxImageBytes >> 20));
    MipMap map;
    map.wrap_ = wrap;
    map.format_ = image.format;
    map.numChannels_ = format.numChannels;
    map.colorSpace_ = &image.ColorSpaceOrSRGB();
    map.byteTable_ = image.encoding.ByteTable();
    for (const Int2 level : PyramidLevels(image.Resolution())) map.levels_.emplace_back(level);
    LevelSink sink(map, format.TexelBytes());
    ImageSource source(image, channels);
    MakePyramid(source, format, wrap, sink);
    map.ChooseLookups();
    return map;
}

MipMap MipMap::OnDisk(std::unique_ptr<const TiledImage> tiles, ColorEncoding encoding, WrapMode wrap,
                      const lacquer::ColorSpace& space) {
    MipMap map;
    const TiledLayout& layout = tiles->Layout();
    map.wrap_ = wrap;
    map.format_ = layout.Format().format;
    map.numChannels_ = layout.Format().numChannels;
    map.colorSpace_ = &space;
    map.byteTable_ = encoding.ByteTable();
    for (int i = 0; i < layout.NumLevels(); ++i) map.levels_.emplace_back(layout.Resolution(i));
    map.tiles_ = std::move(tiles);
    map.ChooseLookups();
    return map;
}

size_t MipMap::Bytes() const {
    size_t bytes = 0;
    for (const Level& level : levels_) bytes += level.bytes;
    return bytes;
}

namespace {

/// The ways of storing texels; 0 channels means that they are counted when the program runs.
template <PixelFormat kFormat, int kChannels = 0>
struct InMemory {
    static constexpr bool kOnDisk = false;
    static constexpr PixelFormat Format(PixelFormat) { return kFormat; }
    static constexpr int Channels(int channels) { return kChannels > 0 ? kChannels : channels; }
};
struct InTiles {
    static constexpr bool kOnDisk = true;
    static PixelFormat Format(PixelFormat format) { return format; }
    static int Channels(int channels) { return channels; }
};

/// a b + c, fused where that is one instruction, and then in all look-ups.
float MultiplyAdd(float a, float b, float c) {
#ifdef FP_FAST_FMAF
    return std::fma(a, b, c);
#else
    return a * b + c;
#endif
}
float Between(float t, float a, float b) { return MultiplyAdd(t, b, (1 - t) * a); }
RGB Between(float t, RGB a, RGB b) {
    return {Between(t, a.x, b.x), Between(t, a.y, b.y), Between(t, a.z, b.z)};
}

}  // namespace

/// The look-ups of a pyramid, compiled for each way of storing texels.
template <class Storage>
class TextureLookup {
  public:
    explicit TextureLookup(const MipMap& map) : map_(map) {}

    /// One value of a texel inside the level.
    float Value(int level, Int2 p, int channel) const { return Decode(Address(level, p), channel); }

    /// Static, as is what it ends with: without an object on the stack the latter is a jump.
    template <class T>
    static T Filter(const MipMap& map, const TextureFootprint& f, TextureFilter filter, float maxAnisotropy);

  private:
    template <class T>
    [[gnu::noinline]] static T FilterInGeneral(const MipMap& map, const TextureFootprint& f,
                                               TextureFilter filter, float maxAnisotropy);
    /// Four texels around a point, and where it is between them. Numbers by themselves: the compiler puts
    /// vectors of two together and takes them apart again.
    struct Cell {
        int x0, y0, x1, y1;
        float dx, dy;
    };
    /// The stored form of a texel, good until the next call.
    const uint8_t* Address(int level, Int2 p) const {
        if constexpr (Storage::kOnDisk) return map_.tiles_->Texel(level, p);
        const MipMap::Level& l = map_.levels_[size_t(level)];
        return l.texels.get() + l.IndexOf(p) * size_t(Channels()) * ValueBytes();
    }
    int Channels() const { return Storage::Channels(map_.numChannels_); }
    PixelFormat Format() const { return Storage::Format(map_.format_); }
    size_t ValueBytes() const {
        return Format() == PixelFormat::Byte ? 1 : Format() == PixelFormat::Half ? 2 : 4;
    }
    float Decode(const uint8_t* texel, int channel) const {
        switch (Format()) {
            case PixelFormat::Byte:
                return map_.byteTable_[texel[channel]];
            case PixelFormat::Half:
                return HalfToFloat(Load<uint16_t>(texel + 2 * channel));
            case PixelFormat::Float:
                break;
        }
        return Load<float>(texel + 4 * channel);
    }
    RGB Color(int level, Int2 p) const {
        const uint8_t* const texel = Address(level, p);
        if (Channels() == 1) return RGB(Decode(texel, 0));
        return {Decode(texel, 0), Decode(texel, 1), Decode(texel, 2)};
    }

    template <class T>
    T Texel(int level, Int2 p) const;
    // These are always inlined: calls between them cost more than what they do.
    [[gnu::always_inline]] inline Cell CellAt(int level, Point2 st) const;
    [[gnu::always_inline]] inline bool WrapCell(int level, Cell* cell) const;
    template <class T>
    [[gnu::always_inline]] inline T Interpolate(int level, const Cell& cell) const;
    template <class T>
    T Bilinear(int level, Point2 st) const;
    template <class T>
    T EwaLevel(int level, Point2 st, Vec2 dst0, Vec2 dst1) const;
    template <class T>
    T Ewa(Point2 st, Vec2 dst0, Vec2 dst1, float maxAnisotropy) const;

    const MipMap& map_;
};

/// One texel, brought in by the wrap mode. As a number it takes channel R of several, as pbrt does in its
/// point and EWA filters and for its coarsest level, though Bilinear<float> has another rule.
template <class Storage>
template <class T>
T TextureLookup<Storage>::Texel(int level, Int2 p) const {
    const Int2 resolution = map_.Resolution(level);
    if (map_.wrap_ == WrapMode::Repeat)
        p = {p.x & (resolution.x - 1), p.y & (resolution.y - 1)};  // sides are powers of two
    else if (!WrapPixel(&p, resolution, map_.wrap_))
        return T(0);
    if constexpr (std::is_same_v<T, RGB>)
        return Color(level, p);
    else
        return Value(level, p, 0);
}

template <class Storage>
typename TextureLookup<Storage>::Cell TextureLookup<Storage>::CellAt(int level, Point2 st) const {
    const MipMap::Level& l = map_.levels_[size_t(level)];
    const float x = st.x * l.size.x - 0.5f, y = st.y * l.size.y - 0.5f;
    const float floorX = std::floor(x), floorY = std::floor(y);
    const int x0 = int(floorX), y0 = int(floorY);
    return {x0, y0, x0 + 1, y0 + 1, x - floorX, y - floorY};
}

/// Wraps the texels of images that repeat; for others, whether all of them are inside.
template <class Storage>
bool TextureLookup<Storage>::WrapCell(int level, Cell* cell) const {
    const Int2 resolution = map_.Resolution(level);
    if (map_.wrap_ != WrapMode::Repeat)
        return cell->x0 >= 0 && cell->y0 >= 0 && cell->x1 < resolution.x && cell->y1 < resolution.y;
    const int maskX = resolution.x - 1, maskY = resolution.y - 1;  // sides are powers of two
    cell->x0 &= maskX;
    cell->x1 &= maskX;
    cell->y0 &= maskY;
    cell->y1 &= maskY;
    return true;
}

/// Between four texels inside the level. As a number, bilinear filtering takes the mean of R, G, B, or alpha
/// where there is one (as pbrt does).
template <class Storage>
template <class T>
T TextureLookup<Storage>::Interpolate(int level, const Cell& c) const {
    const auto interpolate = [&](const auto& texel) {
        return Between(c.dy, Between(c.dx, texel(c.x0, c.y0), texel(c.x1, c.y0)),
                       Between(c.dx, texel(c.x0, c.y1), texel(c.x1, c.y1)));
    };
    const int channels = Channels();
    if (channels == 1 || (channels == 4 && std::is_same_v<T, float>))
        return T(interpolate([&](int x, int y) { return Value(level, {x, y}, channels - 1); }));
    const RGB rgb = interpolate([&](int x, int y) {
        const uint8_t* const texel = Address(level, {x, y});
        return RGB(Decode(texel, 0), Decode(texel, 1), Decode(texel, 2));
    });
    if constexpr (std::is_same_v<T, RGB>)
        return rgb;
    else
        return (rgb.x + rgb.y + rgb.z) / 3;
}

template <class Storage>
template <class T>
T TextureLookup<Storage>::Bilinear(int level, Point2 st) const {
    const Cell cell = CellAt(level, st);
    Cell inside = cell;
    if (WrapCell(level, &inside)) return Interpolate<T>(level, inside);
    // The same where some texels are outside: a cell with all four corners in one texel has its value.
    const auto wrapped = [&](int x, int y) {
        Int2 p{x, y};
        if (!WrapPixel(&p, map_.Resolution(level), map_.wrap_)) return T(0);
        return Interpolate<T>(level, {p.x, p.y, p.x, p.y, 0, 0});
    };
    return Between(cell.dy, Between(cell.dx, wrapped(cell.x0, cell.y0), wrapped(cell.x1, cell.y0)),
                   Between(cell.dx, wrapped(cell.x0, cell.y1), wrapped(cell.x1, cell.y1)));
}

/// Gaussian-weighted mean over an ellipse in one level [Greene and Heckbert 1986].
template <class Storage>
template <class T>
T TextureLookup<Storage>::EwaLevel(int level, Point2 st, Vec2 dst0, Vec2 dst1) const {
    if (level >= map_.NumLevels()) return Texel<T>(map_.NumLevels() - 1, {0, 0});
    const Vec2 resolution(map_.Resolution(level));
    st = st * resolution - Vec2(0.5f);
    dst0 *= resolution;
    dst1 *= resolution;

    // Find the implicit ellipse A s^2 + B s t + C t^2 = 1, widened by one texel so that it always covers
    // some.
    float A = Sqr(dst0.y) + Sqr(dst1.y) + 1, B = -2 * (dst0.x * dst0.y + dst1.x * dst1.y);
    float C = Sqr(dst0.x) + Sqr(dst1.x) + 1;
    const float invF = 1 / (A * C - Sqr(B) / 4);
    A *= invF;
    B *= invF;
    C *= invF;

    // Bound it and add up the texels inside.
    const float det = 4 * A * C - Sqr(B);
    const float sRadius = 2 / det * SafeSqrt(det * C), tRadius = 2 / det * SafeSqrt(A * det);
    const int s0 = int(std::ceil(st.x - sRadius)), s1 = int(std::floor(st.x + sRadius));
    const int t0 = int(std::ceil(st.y - tRadius)), t1 = int(std::floor(st.y + tRadius));
    T sum(0);
    float weights = 0;
    for (int t = t0; t <= t1; ++t) {
        const float dt = float(t) - st.y;
        for (int s = s0; s <= s1; ++s) {
            const float ds = float(s) - st.x;
            const float r2 = A * Sqr(ds) + B * ds * dt + C * Sqr(dt);
            if (!(r2 < 1)) continue;
            const float weight = kEwaTable[size_t(std::min(int(r2 * kEwaTableSize), kEwaTableSize - 1))];
            sum += weight * Texel<T>(level, {s, t});
            weights += weight;
        }
    }
    return weights > 0 ? sum / weights : Bilinear<T>(level, (st + Vec2(0.5f)) / resolution);
}

template <class Storage>
template <class T>
T TextureLookup<Storage>::Ewa(Point2 st, Vec2 dst0, Vec2 dst1, float maxAnisotropy) const {
    // Widen a too narrow ellipse.
    if (glm::dot(dst0, dst0) < glm::dot(dst1, dst1)) std::swap(dst0, dst1);
    const float longer = glm::length(dst0);
    float shorter = glm::length(dst1);
    if (shorter * maxAnisotropy < longer && shorter > 0) {
        const float scale = longer / (shorter * maxAnisotropy);
        dst1 *= scale;
        shorter *= scale;
    }
    if (!(shorter > 0) || !std::isfinite(dst1.x) || !std::isfinite(dst1.y)) return Bilinear<T>(0, st);

    // Interpolate between the levels where the minor axis is one to two texels.
    const float lod = std::max(0.f, float(map_.NumLevels() - 1) + std::log2(shorter));
    if (lod >= float(map_.NumLevels())) return Texel<T>(map_.NumLevels() - 1, {0, 0});
    const float level = std::floor(lod), t = lod - level;
    return (1 - t) * EwaLevel<T>(int(level), st, dst0, dst1) +
           t * EwaLevel<T>(int(level) + 1, st, dst0, dst1);
}

namespace {

/// Extent of a footprint, by which all filters but EWA choose levels, bilinear and point too (as pbrt does).
inline float Width(const TextureFootprint& f) {
    return 2 * std::max(std::max(std::abs(f.dstdx.x), std::abs(f.dstdx.y)),
                        std::max(std::abs(f.dstdy.x), std::abs(f.dstdy.y)));
}

}  // namespace

template <class Storage>
template <class T>
T TextureLookup<Storage>::Filter(const MipMap& map, const TextureFootprint& f, TextureFilter filter,
                                 float maxAnisotropy) {
    // Apart, the most frequent case: it would be slowed down by all others.
    const float width = Width(f);
    const Point2 st = WrapCoordinates(f.st, map.wrap_);
    const bool isNumber = !std::isnan(st.x) && !std::isnan(st.y);
    if (isNumber && width < 1 && filter == TextureFilter::Bilinear) {
        const TextureLookup lookup(map);
        const int level = std::max(0, map.NumLevels() - 1 + FloorLog2(width));
        Cell cell = lookup.CellAt(level, st);
        if (lookup.WrapCell(level, &cell)) return lookup.template Interpolate<T>(level, cell);
    }
    return FilterInGeneral<T>(map, f, filter, maxAnisotropy);
}

template <class Storage>
template <class T>
T TextureLookup<Storage>::FilterInGeneral(const MipMap& map, const TextureFootprint& f, TextureFilter filter,
                                          float maxAnisotropy) {
    const TextureLookup lookup(map);
    const float width = Width(f);
    const int top = map.NumLevels() - 1;
    const bool finite = std::isfinite(f.st.x) && std::isfinite(f.st.y) && width < 1e15f;
    if (!finite) return lookup.template Texel<T>(top, {0, 0});
    const Point2 st = WrapCoordinates(f.st, map.wrap_);
    if (filter == TextureFilter::EWA) return lookup.template Ewa<T>(st, f.dstdx, f.dstdy, maxAnisotropy);
    if (width >= 1) return lookup.template Texel<T>(top, {0, 0});
    const int base = std::max(0, top + FloorLog2(width));
    if (filter == TextureFilter::Point) {
        const Vec2 p = st * Vec2(map.Resolution(base)) - Vec2(0.5f);
        return lookup.template Texel<T>(base, {int(std::round(p.x)), int(std::round(p.y))});
    }
    if (filter == TextureFilter::Bilinear) return lookup.template Bilinear<T>(base, st);
    const float level = float(top) + std::log2(std::max(width, 1e-8f));
    if (level <= 0) return lookup.template Bilinear<T>(base, st);
    const float t = std::clamp(level - float(base), 0.f, 1.f);
    return (1 - t) * lookup.template Bilinear<T>(base, st) + t * lookup.template Bilinear<T>(base + 1, st);
}

template <class Storage>
MipMap::Lookups MipMap::LookupsOf() {
    Lookups lookups;
    lookups.value = [](const MipMap& map, int level, Int2 p, int channel) {
        return TextureLookup<Storage>(map).Value(level, p, channel);
    };
    lookups.filterFloat = [](const MipMap& map, const TextureFootprint& footprint, TextureFilter filter,
                             float maxAnisotropy) {
        return TextureLookup<Storage>::template Filter<float>(map, footprint, filter, maxAnisotropy);
    };
    lookups.filterRGB = [](const MipMap& map, const TextureFootprint& footprint, TextureFilter filter,
                           float maxAnisotropy) {
        return TextureLookup<Storage>::template Filter<RGB>(map, footprint, filter, maxAnisotropy);
    };
    return lookups;
}

void MipMap::ChooseLookups() {
    if (tiles_)
        lookups_ = LookupsOf<InTiles>();
    else if (format_ == PixelFormat::Float)
        lookups_ = LookupsOf<InMemory<PixelFormat::Float>>();
    else if (format_ == PixelFormat::Half)
        lookups_ = LookupsOf<InMemory<PixelFormat::Half>>();
    else if (numChannels_ == 1)
        lookups_ = LookupsOf<InMemory<PixelFormat::Byte, 1>>();
    else if (numChannels_ == 3)
        lookups_ = LookupsOf<InMemory<PixelFormat::Byte, 3>>();
    else
        lookups_ = LookupsOf<InMemory<PixelFormat::Byte, 4>>();
}

float MipMap::Texel(int level, Int2 p, int channel) const {
    return WrapPixel(&p, Resolution(level), wrap_) ? lookups_.value(*this, level, p, channel) : 0.f;
}

}  // namespace lacquer
