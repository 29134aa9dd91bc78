#include "pbrt/image/mipmap.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace lacquer {

namespace {

/// Sinc of unit period under a sinc window of radius 2.
float WindowedSinc(float x) {
    constexpr float kRadius = 2;
    if (std::abs(x) > kRadius) return 0;
    return SinXOverX(Pi * x) * SinXOverX(Pi * x / kRadius);
}

/// The four source pixels of one pixel of an enlarged axis.
struct Taps {
    int first = 0;
    float weights[4] = {};
};

std::vector<Taps> MakeTaps(int from, int to) {
    std::vector<Taps> taps(static_cast<size_t>(to));
    for (int i = 0; i < to; ++i) {
        Taps& t = taps[size_t(i)];
        const float center = (float(i) + 0.5f) * float(from) / float(to);
        t.first = int(std::floor(center - 1.5f));
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            t.weights[k] = WindowedSinc(float(t.first + k) + 0.5f - center);
            sum += t.weights[k];
        }
        for (float& w : t.weights) w /= sum;
    }
    return taps;
}

/// Rows of an image enlarged to another size, made one after the other; four rows enlarged along x are kept.
class Enlarger {
  public:
    Enlarger(const Image& image, const std::vector<int>& channels, Int2 resolution, WrapMode wrap)
        : image_(image),
          channels_(channels),
          wrap_(wrap),
          resolution_(resolution),
          xTaps_(MakeTaps(image.Resolution().x, resolution.x)),
          yTaps_(MakeTaps(image.Resolution().y, resolution.y)) {
        low_ = std::min(0.f, *std::min_element(image.Pixels().begin(), image.Pixels().end()));
        for (Row& row : rows_) row.values.resize(size_t(resolution.x) * channels.size());
    }

    void MakeRow(int y, std::vector<float>* out) {
        out->resize(rows_[0].values.size());
        if (resolution_ == image_.Resolution()) return CopyRow(y, out->data());
        const Taps& taps = yTaps_[size_t(y)];
        const float* rows[4];
        for (int k = 0; k < 4; ++k) rows[k] = RowAlongX(taps.first + k);
        for (size_t i = 0; i < out->size(); ++i) {
            float sum = 0;
            for (int k = 0; k < 4; ++k) sum += taps.weights[k] * rows[k][i];
            // The sinc's negative lobes must not make negative values where there are none.
            (*out)[i] = std::max(low_, sum);
        }
    }

  private:
    struct Row {
        int y = std::numeric_limits<int>::min();
        std::vector<float> values;
    };

    void CopyRow(int y, float* out) const {
        for (int x = 0; x < resolution_.x; ++x)
            for (int c : channels_) *out++ = image_.Get({x, y}, c);
    }

    const float* RowAlongX(int y) {
        Row& row = rows_[Mod(y, 4)];
        if (row.y == y) return row.values.data();
        row.y = y;
        float* out = row.values.data();
        for (int x = 0; x < resolution_.x; ++x) {
            const Taps& taps = xTaps_[size_t(x)];
            for (int c : channels_) {
                float sum = 0;
                for (int k = 0; k < 4; ++k)
                    sum += taps.weights[k] * image_.GetWrapped({taps.first + k, y}, c, wrap_);
                *out++ = sum;
            }
        }
        return row.values.data();
    }

    const Image& image_;
    const std::vector<int>& channels_;
    WrapMode wrap_;
    Int2 resolution_;
    std::vector<Taps> xTaps_, yTaps_;
    Row rows_[4];
    float low_ = 0;
};

/// Indices of the channels that a texture uses.
std::vector<int> UsedChannels(const Image& image, const std::string& path, const FileLoc& loc) {
    if (image.NumChannels() == 1) return {0};
    const int r = image.FindChannel("R"), g = image.FindChannel("G"), b = image.FindChannel("B");
    const int a = image.FindChannel("A");
    if (r < 0 || g < 0 || b < 0) {
        std::string names;
        for (const std::string& name : image.Channels()) names += (names.empty() ? "" : ", ") + name;
        throw SceneError(loc, fmt::format("{}: a texture needs one channel, or R, G and B; this image has {}",
                                          path, names));
    }
    if (a < 0) return {r, g, b};
    // An alpha of 1 everywhere says nothing; without it, float textures take the mean of R, G and B.
    for (size_t i = size_t(a); i < image.Pixels().size(); i += size_t(image.NumChannels()))
        if (image.Pixels()[i] != 1) return {r, g, b, a};
    return {r, g, b};
}

/// Adds up row `y` of a level with `width` texels a row into the sums of the level above.
void AddToCoarser(const float* row, Int2 resolution, int y, int channels, std::vector<float>* coarser) {
    const Int2 half = glm::max(Int2(1), resolution / 2);
    // Along an axis of one texel there is only one to average.
    const float weight = (resolution.x > 1 ? 0.5f : 1.f) * (resolution.y > 1 ? 0.5f : 1.f);
    float* const sums =
        coarser->data() + size_t(std::min(y / 2, half.y - 1)) * size_t(half.x) * size_t(channels);
    for (int x = 0; x < resolution.x; ++x)
        for (int c = 0; c < channels; ++c)
            sums[std::min(x / 2, half.x - 1) * channels + c] += weight * row[x * channels + c];
}

size_t NumValues(Int2 resolution, int channels) {
    return size_t(resolution.x) * size_t(resolution.y) * size_t(channels);
}

size_t BytesOf(PixelFormat format) {
    return format == PixelFormat::Byte ? 1 : format == PixelFormat::Half ? 2 : 4;
}

/// Weights of a Gaussian that ends at radius 1, by squared radius in steps of 1/128.
constexpr int kEwaTableSize = 128;
const std::array<float, kEwaTableSize>& EwaTable() {
    static const auto table = [] {
        std::array<float, kEwaTableSize> values;
        constexpr float alpha = 2;
        for (size_t i = 0; i < kEwaTableSize; ++i)
            values[i] = std::exp(-alpha * float(i) / (kEwaTableSize - 1)) - std::exp(-alpha);
        return values;
    }();
    return table;
}

/// True if R, G and B agree in every pixel.
bool IsGrey(const Image& image) {
    const std::vector<float>& v = image.Pixels();
    const size_t stride = size_t(image.NumChannels());
    for (size_t i = 0; i + 2 < v.size(); i += stride)
        if (v[i] != v[i + 1] || v[i] != v[i + 2]) return false;
    return true;
}

}  // namespace

MipMap MipMap::Make(const Image& image, WrapMode wrap, const std::string& path, const FileLoc& loc) {
    std::vector<int> channels = UsedChannels(image, path, loc);
    // A grey picture in three channels needs one: all filters give the same numbers from a third of the
    // memory.
    if (channels.size() == 3 && IsGrey(image)) channels.resize(1);
    if (image.HasNonFinite())
        throw SceneError(
            loc, fmt::format("{}: the image has pixels that are not finite numbers; a texture needs numbers",
                             path));
    MipMap map;
    map.wrap_ = wrap;
    map.format_ = image.format;
    map.encoding_ = image.encoding;
    map.numChannels_ = int(channels.size());
    map.colorSpace_ = &image.ColorSpaceOrSRGB();
    map.byteTable_ = image.encoding.ByteTable();
    const Int2 resolution{RoundUpPowerOf2(image.Resolution().x), RoundUpPowerOf2(image.Resolution().y)};
    const size_t bytes = NumValues(resolution, map.numChannels_) * BytesOf(image.format);
    if (bytes > kMaxImageBytes)
        throw SceneError(
            loc, fmt::format("{}: the image takes {} MiB once its sides are powers of two; the limit is {}",
                             path, bytes >> 20, kMaxImageBytes >> 20));
    map.AddCoarserLevels(map.StoreBaseLevel(image, channels, resolution));
    return map;
}

void MipMap::AllocateLevel(Level* level, Int2 resolution) const {
    level->resolution = resolution;
    const size_t n = NumValues(resolution, numChannels_);
    switch (format_) {
        case PixelFormat::Byte:
            level->bytes.resize(n);
            return;
        case PixelFormat::Half:
            level->halves.resize(n);
            return;
        case PixelFormat::Float:
            level->floats.resize(n);
            return;
    }
}

void MipMap::Store(Level* level, size_t index, float value) const {
    switch (format_) {
        case PixelFormat::Byte:
            level->bytes[index] = uint8_t(encoding_.FromLinear(value) * 255 + 0.5f);
            return;
        case PixelFormat::Half:
            level->halves[index] = FloatToHalf(std::clamp(value, -kMaxHalf, kMaxHalf));
            return;
        case PixelFormat::Float:
            level->floats[index] = value;
            return;
    }
}

/// Stores level 0 row by row, rounded to the image's own format as pbrt does, and returns level 1 as floats.
std::vector<float> MipMap::StoreBaseLevel(const Image& image, const std::vector<int>& channels,
                                          Int2 resolution) {
    levels_.emplace_back();
    AllocateLevel(&levels_[0], resolution);
    std::vector<float> coarser(NumValues(glm::max(Int2(1), resolution / 2), numChannels_));
    Enlarger enlarger(image, channels, resolution, wrap_);
    std::vector<float> row;
    size_t index = 0;
    for (int y = 0; y < resolution.y; ++y) {
        enlarger.MakeRow(y, &row);
        for (float& value : row) {
            Store(&levels_[0], index, value);
            value = Fetch(levels_[0], index++);
        }
        AddToCoarser(row.data(), resolution, y, numChannels_, &coarser);
    }
    return coarser;
}

/// Stores level 1, given as floats, and all above it. Rounding to the format does not add up over the levels.
void MipMap::AddCoarserLevels(std::vector<float> finer) {
    Int2 resolution = levels_[0].resolution;
    while (resolution != Int2(1)) {
        resolution = glm::max(Int2(1), resolution / 2);
        Level level;
        AllocateLevel(&level, resolution);
        for (size_t i = 0; i < finer.size(); ++i) Store(&level, i, finer[i]);
        levels_.push_back(std::move(level));
        std::vector<float> coarser(NumValues(glm::max(Int2(1), resolution / 2), numChannels_));
        for (int y = 0; y < resolution.y; ++y)
            AddToCoarser(finer.data() + NumValues({resolution.x, y}, numChannels_), resolution, y,
                         numChannels_, &coarser);
        finer = std::move(coarser);
    }
}

size_t MipMap::Bytes() const {
    size_t bytes = 0;
    for (const Level& level : levels_)
        bytes += level.bytes.size() + 2 * level.halves.size() + 4 * level.floats.size();
    return bytes;
}

float MipMap::Texel(int level, Int2 p, int channel) const {
    const Level& l = levels_[size_t(level)];
    if (!WrapPixel(&p, l.resolution, wrap_)) return 0;
    return Fetch(l, NumValues({l.resolution.x, p.y}, numChannels_) + size_t(p.x * numChannels_ + channel));
}

/// One texel as a number takes channel R of several, as pbrt does in its point and EWA filters and for its
/// coarsest level, though BilinearAs<float> has another rule.
template <>
float MipMap::TexelAs<float>(int level, Int2 p) const {
    return Texel(level, p, 0);
}

template <>
RGB MipMap::TexelAs<RGB>(int level, Int2 p) const {
    const Level& l = levels_[size_t(level)];
    if (wrap_ == WrapMode::Repeat)
        p = {p.x & (l.resolution.x - 1), p.y & (l.resolution.y - 1)};  // sides are powers of two
    else if (!WrapPixel(&p, l.resolution, wrap_))
        return RGB(0);
    const size_t i = NumValues({l.resolution.x, p.y}, numChannels_) + size_t(p.x * numChannels_);
    if (numChannels_ == 1) return RGB(Fetch(l, i));
    return {Fetch(l, i), Fetch(l, i + 1), Fetch(l, i + 2)};
}

namespace {

template <class T, class GetTexel>
T Interpolate(Point2 st, Int2 resolution, const GetTexel& texel) {
    const float x = st.x * float(resolution.x) - 0.5f, y = st.y * float(resolution.y) - 0.5f;
    const int xi = int(std::floor(x)), yi = int(std::floor(y));
    const float dx = x - float(xi), dy = y - float(yi);
    const T top = (1 - dx) * texel(Int2(xi, yi)) + dx * texel(Int2(xi + 1, yi));
    const T bottom = (1 - dx) * texel(Int2(xi, yi + 1)) + dx * texel(Int2(xi + 1, yi + 1));
    return (1 - dy) * top + dy * bottom;
}

}  // namespace

/// As a number, bilinear filtering takes the mean of R, G, B, or alpha where there is one (as pbrt does).
template <>
float MipMap::BilinearAs<float>(int level, Point2 st) const {
    const Int2 resolution = levels_[size_t(level)].resolution;
    if (numChannels_ == 3) {
        const RGB rgb = Interpolate<RGB>(st, resolution, [&](Int2 p) { return TexelAs<RGB>(level, p); });
        return (rgb.x + rgb.y + rgb.z) / 3;
    }
    const int channel = numChannels_ == 4 ? 3 : 0;
    return Interpolate<float>(st, resolution, [&](Int2 p) { return Texel(level, p, channel); });
}

template <>
RGB MipMap::BilinearAs<RGB>(int level, Point2 st) const {
    const Level& l = levels_[size_t(level)];
    if (numChannels_ == 1 && format_ == PixelFormat::Byte && wrap_ == WrapMode::Repeat) {
        // The commonest case by far, without a branch a texel.
        const Int2 mask = l.resolution - 1;
        const auto texel = [&](Int2 p) {
            return byteTable_[l.bytes[size_t(p.y & mask.y) * size_t(l.resolution.x) + size_t(p.x & mask.x)]];
        };
        return RGB(Interpolate<float>(st, l.resolution, texel));
    }
    if (numChannels_ == 1)
        return RGB(Interpolate<float>(st, l.resolution, [&](Int2 p) { return Texel(level, p, 0); }));
    return Interpolate<RGB>(st, levels_[size_t(level)].resolution,
                            [&](Int2 p) { return TexelAs<RGB>(level, p); });
}

/// Gaussian-weighted mean over an ellipse in one level [Greene and Heckbert 1986].
template <class T>
T MipMap::EwaLevel(int level, Point2 st, Vec2 dst0, Vec2 dst1) const {
    if (level >= NumLevels()) return TexelAs<T>(NumLevels() - 1, {0, 0});
    const Vec2 resolution(Resolution(level));
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
            const float weight = EwaTable()[size_t(std::min(int(r2 * kEwaTableSize), kEwaTableSize - 1))];
            sum += weight * TexelAs<T>(level, {s, t});
            weights += weight;
        }
    }
    return weights > 0 ? sum / weights : BilinearAs<T>(level, (st + Vec2(0.5f)) / resolution);
}

template <class T>
T MipMap::Ewa(Point2 st, Vec2 dst0, Vec2 dst1, float maxAnisotropy) const {
    // Widen a too narrow ellipse.
    if (glm::dot(dst0, dst0) < glm::dot(dst1, dst1)) std::swap(dst0, dst1);
    const float longer = glm::length(dst0);
    float shorter = glm::length(dst1);
    if (shorter * maxAnisotropy < longer && shorter > 0) {
        const float scale = longer / (shorter * maxAnisotropy);
        dst1 *= scale;
        shorter *= scale;
    }
    if (!(shorter > 0) || !std::isfinite(dst1.x) || !std::isfinite(dst1.y)) return BilinearAs<T>(0, st);

    // Interpolate between the levels where the minor axis is one to two texels.
    const float lod = std::max(0.f, float(NumLevels() - 1) + std::log2(shorter));
    if (lod >= float(NumLevels())) return TexelAs<T>(NumLevels() - 1, {0, 0});
    const float level = std::floor(lod), t = lod - level;
    return (1 - t) * EwaLevel<T>(int(level), st, dst0, dst1) +
           t * EwaLevel<T>(int(level) + 1, st, dst0, dst1);
}

template <class T>
T MipMap::Filter(const TextureFootprint& f, TextureFilter filter, float maxAnisotropy) const {
    const int top = NumLevels() - 1;
    const float width =
        2 * std::max({std::abs(f.dstdx.x), std::abs(f.dstdx.y), std::abs(f.dstdy.x), std::abs(f.dstdy.y)});
    const bool finite = std::isfinite(f.st.x) && std::isfinite(f.st.y) && width < 1e15f;
    if (!finite) return TexelAs<T>(top, {0, 0});
    const Point2 st = WrapCoordinates(f.st, wrap_);
    if (filter == TextureFilter::EWA) return Ewa<T>(st, f.dstdx, f.dstdy, maxAnisotropy);

    // All other filters choose levels by the larger extent of the footprint, bilinear and point too (as pbrt
    // does).
    const float level = float(top) + std::log2(std::max(width, 1e-8f));
    if (level >= float(top)) return TexelAs<T>(top, {0, 0});
    const int base = std::max(0, int(std::floor(level)));
    if (filter == TextureFilter::Point) {
        const Vec2 p = st * Vec2(Resolution(base)) - Vec2(0.5f);
        return TexelAs<T>(base, {int(std::round(p.x)), int(std::round(p.y))});
    }
    if (filter == TextureFilter::Bilinear || level <= 0) return BilinearAs<T>(base, st);
    const float t = level - float(base);
    return (1 - t) * BilinearAs<T>(base, st) + t * BilinearAs<T>(base + 1, st);
}

float MipMap::FilterFloat(const TextureFootprint& footprint, TextureFilter filter,
                          float maxAnisotropy) const {
    return Filter<float>(footprint, filter, maxAnisotropy);
}

RGB MipMap::FilterRGB(const TextureFootprint& footprint, TextureFilter filter, float maxAnisotropy) const {
    return Filter<RGB>(footprint, filter, maxAnisotropy);
}

}  // namespace lacquer
