// Look-ups of image textures against the same in a plain array.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "pbrt/core/rng.h"
#include "pbrt/image/mipmap.h"
#include "pbrt/image/texture_files.h"

namespace lacquer {
namespace {

constexpr int kSide = 512;
constexpr ColorEncoding kSRGB{ColorEncoding::Kind::SRGB, 1};

/// Noise in three channels, or in one.
Image Noise(int side, bool isGrey) {
    Image image({side, side}, {"R", "G", "B"});
    Rng rng(1);
    for (size_t i = 0; i < image.Pixels().size(); i += 3)
        for (size_t c = 0; c < 3; ++c)
            image.Pixels()[i + c] = isGrey && c > 0 ? image.Pixels()[i] : rng.Uniform();
    image.format = PixelFormat::Byte;
    image.encoding = kSRGB;
    return image;
}

/// Bytes that repeat, interpolated between four texels: nothing else, not even levels.
template <int kChannels>
class PlainArray {
  public:
    explicit PlainArray(const Image& image) : side_(image.Resolution().x), table_(kSRGB.ByteTable()) {
        for (size_t i = 0; i < image.Pixels().size(); i += 3)
            for (size_t c = 0; c < kChannels; ++c)
                bytes_.push_back(uint8_t(kSRGB.FromLinear(image.Pixels()[i + c]) * 255 + 0.5f));
    }
    RGB Bilinear(Point2 st) const {
        const float x = st.x * float(side_) - 0.5f, y = st.y * float(side_) - 0.5f;
        const int xi = int(std::floor(x)), yi = int(std::floor(y));
        const float dx = x - float(xi), dy = y - float(yi);
        return (1 - dy) * ((1 - dx) * Texel(xi, yi) + dx * Texel(xi + 1, yi)) +
               dy * ((1 - dx) * Texel(xi, yi + 1) + dx * Texel(xi + 1, yi + 1));
    }

  private:
    RGB Texel(int x, int y) const {
        const uint8_t* texel =
            &bytes_[(size_t(y & (side_ - 1)) * size_t(side_) + size_t(x & (side_ - 1))) * kChannels];
        if constexpr (kChannels == 1) return RGB(table_[texel[0]]);
        return {table_[texel[0]], table_[texel[1]], table_[texel[2]]};
    }
    int side_;
    std::vector<uint8_t> bytes_;
    std::array<float, 256> table_;
};

/// The same look-up as of an image texture that repeats, written for plain arrays of bytes and nothing else:
/// the level that the footprint asks for, then four of its texels.
template <int kChannels>
class PlainPyramid {
  public:
    explicit PlainPyramid(const Image& image) {
        for (Int2 r = image.Resolution();; r /= 2) {
            levels_.emplace_back(Resize(image, r));
            if (r == Int2(1)) return;
        }
    }
    [[gnu::noinline]] RGB Filter(const TextureFootprint& f) const {
        const float width = 2 * std::max({std::abs(f.dstdx.x), std::abs(f.dstdx.y), std::abs(f.dstdy.x),
                                          std::abs(f.dstdy.y)});
        const float level = float(levels_.size() - 1) + std::log2(std::max(width, 1e-8f));
        return levels_[size_t(std::max(0, int(std::floor(level))))].Bilinear(f.st);
    }

  private:
    std::vector<PlainArray<kChannels>> levels_;
};

/// Points as neighbouring pixels have them (a short step each), or anywhere.
std::vector<Point2> Points(bool areNear) {
    Rng rng(2);
    std::vector<Point2> points(4096);
    Point2 at{0.3f, 0.4f};
    for (Point2& p : points) {
        at += 2.f / kSide * (rng.Uniform2D() - Vec2(0.5f));
        p = areNear ? at : rng.Uniform2D();
    }
    return points;
}

template <class LookUp>
void Run(benchmark::State& state, bool areNear, const LookUp& lookUp) {
    const std::vector<Point2> points = Points(areNear);
    for (const Point2 p : points) benchmark::DoNotOptimize(lookUp(p));  // reads tiles, fills caches
    size_t i = 0;
    for (auto _ : state) {
        (void)_;
        benchmark::DoNotOptimize(lookUp(points[i++ % points.size()]));
    }
}

template <int kChannels>
void TexturePlainArray(benchmark::State& state) {
    const PlainArray<kChannels> array(Noise(kSide, kChannels == 1));
    Run(state, state.range(0) != 0, [&](Point2 st) { return array.Bilinear(st); });
}

TextureFootprint Footprint(Point2 st) {
    constexpr float kPixel = 0.5f / kSide;
    return {st, {kPixel, 0}, {0, kPixel}};
}

RGB LookUp(const MipMap& map, Point2 st) { return map.FilterRGB(Footprint(st), TextureFilter::Bilinear, 8); }

template <int kChannels>
void TexturePlainPyramid(benchmark::State& state) {
    const PlainPyramid<kChannels> pyramid(Noise(kSide, kChannels == 1));
    Run(state, state.range(0) != 0, [&](Point2 st) { return pyramid.Filter(Footprint(st)); });
}

template <int kChannels>
void TextureInMemory(benchmark::State& state) {
    const MipMap map = MipMap::Make(Noise(kSide, kChannels == 1), WrapMode::Repeat, "noise", {});
    Run(state, state.range(0) != 0, [&](Point2 st) { return LookUp(map, st); });
}

/// The same image from tiles; a thread keeps as many as it has.
void TextureInTiles(benchmark::State& state) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    const std::string path = (folder / "lacquer-texture-bench.png").string();
    WriteImage(Noise(kSide, false), path);
    {
        TextureFiles files({8, "", folder.string()}, nullptr);
        const MipMap map = files.Load(path, kSRGB, WrapMode::Repeat, {});
        Run(state, state.range(0) != 0, [&](Point2 st) { return LookUp(map, st); });
        if (files.Tiles().HasFailed()) state.SkipWithError(files.Tiles().Failure().c_str());
    }
    std::filesystem::remove(path);
}

// Argument: 1 for points near each other, 0 for points anywhere.
BENCHMARK(TexturePlainArray<3>)->Arg(1)->Arg(0);
BENCHMARK(TexturePlainPyramid<3>)->Arg(1)->Arg(0);
BENCHMARK(TextureInMemory<3>)->Arg(1)->Arg(0);
BENCHMARK(TexturePlainArray<1>)->Arg(1)->Arg(0);
BENCHMARK(TexturePlainPyramid<1>)->Arg(1)->Arg(0);
BENCHMARK(TextureInMemory<1>)->Arg(1)->Arg(0);
BENCHMARK(TextureInTiles)->Arg(1)->Arg(0);

}  // namespace
}  // namespace lacquer
