#include "pbrt/image/operations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pbrt/core/math.h"
#include "pbrt/core/parallel.h"

namespace lacquer {

std::string_view LayerOfChannel(std::string_view channel) {
    const size_t dot = channel.rfind('.');
    return dot == std::string_view::npos ? std::string_view() : channel.substr(0, dot);
}

std::vector<int> ColorChannels(const Image& image) {
    if (image.HasRGB()) return {0, 1, 2};
    const int grey = image.FindChannel("Y");
    return grey < 0 ? std::vector<int>() : std::vector<int>{grey};
}

float LuminanceAt(const Image& image, Int2 p) {
    if (image.HasRGB())
        return image.ColorSpaceOrSRGB().Luminance(RGB(image.Get(p, 0), image.Get(p, 1), image.Get(p, 2)));
    if (const int grey = image.FindChannel("Y"); grey >= 0) return image.Get(p, grey);
    float sum = 0;
    for (int c = 0; c < image.NumChannels(); ++c) sum += image.Get(p, c);
    return sum / float(image.NumChannels());
}

bool MapColors(Image* image, const std::function<RGB(RGB)>& function) {
    const std::vector<int> channels = ColorChannels(*image);
    if (channels.empty()) return false;
    const Int2 size = image->Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Int2 p(x, y);
            RGB rgb(image->Get(p, channels[0]));
            for (size_t c = 1; c < channels.size(); ++c) rgb[int(c)] = image->Get(p, channels[c]);
            const RGB mapped = function(rgb);
            for (size_t c = 0; c < channels.size(); ++c) image->Set(p, channels[c], mapped[int(c)]);
        }
    return true;
}

void FlipY(Image* image) {
    const auto row = size_t(image->Resolution().x) * size_t(image->NumChannels());
    std::vector<float>& pixels = image->Pixels();
    const int height = image->Resolution().y;
    for (int y = 0; y < height / 2; ++y)
        std::swap_ranges(pixels.begin() + ptrdiff_t(size_t(y) * row),
                         pixels.begin() + ptrdiff_t(size_t(y + 1) * row),
                         pixels.begin() + ptrdiff_t(size_t(height - 1 - y) * row));
}

Image RepeatPixels(const Image& image, int n) {
    const Int2 size = image.Resolution() * n;
    Image result(size, image.Channels());
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < image.NumChannels(); ++c) result.Set({x, y}, c, image.Get({x / n, y / n}, c));
    result.SetColorSpace(image.ColorSpace());
    result.metadata = image.metadata;
    result.floatChannels = image.floatChannels;
    result.format = image.format;
    if (!image.dataWindow.IsEmpty()) result.dataWindow = {image.dataWindow.min * n, image.dataWindow.max * n};
    result.fullResolution = image.fullResolution * n;
    return result;
}

int64_t Despike(Image* image, float threshold) {
    const Image before = *image;
    const Int2 size = image->Resolution();
    int64_t count = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Int2 p(x, y);
            if (!(LuminanceAt(before, p) > threshold)) continue;
            ++count;
            for (int c = 0; c < image->NumChannels(); ++c) {
                std::array<float, 9> around;
                for (int i = 0; i < 9; ++i)
                    around[size_t(i)] = before.GetWrapped({x + i % 3 - 1, y + i / 3 - 1}, c, WrapMode::Clamp);
                std::nth_element(around.begin(), around.begin() + 4, around.end());
                image->Set(p, c, around[4]);
            }
        }
    return count;
}

namespace {

/// A Gaussian of `width` pixels, three standard deviations to each side.
std::vector<float> BlurWeights(int width) {
    const int radius = std::max(width / 2, 1);
    const float sigma = float(radius) / 3;
    std::vector<float> weights;
    float sum = 0;
    for (int i = -radius; i <= radius; ++i) {
        weights.push_back(std::exp(-0.5f * Sqr(float(i) / sigma)));
        sum += weights.back();
    }
    for (float& w : weights) w /= sum;
    return weights;
}

/// Adds the `count` values from `from` on, times `weight`, to those from `to` on.
void AddWeighted(const float* from, float weight, size_t count, float* to) {
    for (size_t i = 0; i < count; ++i) to[i] += weight * from[i];
}

/// Along x or y; black outside. Rows are added to rows, with what lies outside left out, so that the cost is
/// that of the smaller one of width and image.
Image BlurAlong(const Image& image, const std::vector<float>& weights, Int2 step) {
    const Int2 size = image.Resolution();
    const int radius = int(weights.size()) / 2;
    const auto channels = size_t(image.NumChannels()), stride = size_t(size.x) * channels;
    Image result(size, image.Channels());
    ParallelFor(size.y, [&](int64_t y) {
        float* to = result.Pixels().data() + size_t(y) * stride;
        const Int2 limit = step.x != 0 ? Int2(-size.x, size.x) : Int2(-int(y) - 1, size.y - int(y));
        for (int i = std::max(-radius, limit.x + 1); i <= std::min(radius, limit.y - 1); ++i) {
            const float weight = weights[size_t(i + radius)];
            const float* from = image.Pixels().data() + size_t(y + int64_t(i) * step.y) * stride;
            const size_t shift = size_t(step.x != 0 ? std::abs(i) : 0) * channels;
            AddWeighted(from + (i > 0 ? shift : 0), weight, stride - shift, to + (i < 0 ? shift : 0));
        }
    });
    return result;
}

}  // namespace

int64_t Bloom(Image* image, const BloomOptions& options) {
    const std::vector<int> channels = ColorChannels(*image);
    const Int2 size = image->Resolution();
    Image bright(size, std::vector<std::string>(channels.size(), "C"));
    int64_t count = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const Int2 p(x, y);
            const bool isBright = std::any_of(channels.begin(), channels.end(),
                                              [&](int c) { return image->Get(p, c) > options.level; });
            count += isBright;
            for (size_t c = 0; isBright && c < channels.size(); ++c)
                bright.Set(p, int(c), image->Get(p, channels[c]));
        }
    if (count == 0) return 0;
    const std::vector<float> weights = BlurWeights(options.width);
    for (int i = 0; i < options.iterations; ++i) {
        bright = BlurAlong(BlurAlong(bright, weights, {1, 0}), weights, {0, 1});
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                for (size_t c = 0; c < channels.size(); ++c)
                    image->Set({x, y}, channels[c],
                               image->Get({x, y}, channels[c]) +
                                   options.scale / float(options.iterations) * bright.Get({x, y}, int(c)));
    }
    return count;
}

Assembly Assemble(std::span<const Image> parts) {
    const Image& first = parts[0];
    const Int2 size = first.FrameResolution();
    Assembly result{Image(size, first.Channels())};
    result.image.SetColorSpace(first.ColorSpace());
    result.image.metadata = first.metadata;
    result.image.floatChannels = first.floatChannels;
    result.image.format = first.format;
    std::vector<bool> covered(size_t(size.x) * size_t(size.y));
    const Bounds2i frame{{0, 0}, size};
    for (const Image& part : parts) {
        std::vector<int> channels;
        for (const std::string& name : first.Channels()) channels.push_back(part.FindChannel(name));
        const Bounds2i window = part.Window(), inside = window.Intersect(frame);
        for (int y = inside.min.y; y < inside.max.y; ++y)
            for (int x = inside.min.x; x < inside.max.x; ++x) {
                const size_t index = size_t(y) * size_t(size.x) + size_t(x);
                result.overlapping += covered[index];
                covered[index] = true;
                for (size_t c = 0; c < channels.size(); ++c)
                    result.image.Set({x, y}, int(c), part.Get(Int2(x, y) - window.min, channels[c]));
            }
    }
    result.missing = std::count(covered.begin(), covered.end(), false);
    return result;
}

Image Strips(std::span<const Image> images) {
    Image result = images[0];
    const Int2 size = result.Resolution();
    for (int x = 0; x < size.x; ++x) {
        const Image& from = images[size_t(x) * images.size() / size_t(size.x)];
        for (int c = 0; c < result.NumChannels(); ++c) {
            const int channel = from.FindChannel(result.Channels()[size_t(c)]);
            for (int y = 0; y < size.y; ++y) result.Set({x, y}, c, from.Get({x, y}, channel));
        }
    }
    return result;
}

void ScaleNormals(Image* image, float scale) {
    MapColors(image, [scale](RGB encoded) {
        const Vec3 n = 2.f * Vec3(encoded) - 1.f;
        const Vec3 scaled(scale * n.x, scale * n.y, n.z);
        const float length = Length(scaled);
        return length > 0 ? RGB(0.5f * (scaled / length) + 0.5f) : encoded;
    });
}

}  // namespace lacquer
