// From the channels of an image to what the denoiser works on.
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "denoise/denoiser.h"
#include "pbrt/core/math.h"

namespace lacquer::denoise {
namespace {

constexpr const char* kFeatureChannels[kNumFeatures] = {"Albedo.R", "Albedo.G", "Albedo.B", "Ns.X",
                                                        "Ns.Y",     "Ns.Z",     "Z"};
constexpr int kDepth = kNumFeatures - 1;
constexpr int kVarianceRadius = 3;
constexpr float kMinShape = 0.2f;

int Channel(const Image& image, const std::string& name) {
    const int c = image.FindChannel(name);
    if (c < 0)
        throw std::invalid_argument(fmt::format(
            "has no channel {}; render with --denoise, or with --aov half,variance,albedo,normal,depth",
            name));
    return c;
}

/// Samples of each pixel, and of its halves. Errors: std::invalid_argument if the image does not say.
class SampleCounts {
  public:
    explicit SampleCounts(const Image& image)
        : image_(image), all_(image.FindChannel("samples")), first_(image.FindChannel("Half.samples")) {
        if (all_ >= 0) return;
        const auto found = image.metadata.find("samplesPerPixel");
        const int* count = found == image.metadata.end() ? nullptr : std::get_if<int>(&found->second);
        if (!count) throw std::invalid_argument("does not say how many samples it has (samplesPerPixel)");
        ofAll_ = float(*count);
    }
    float At(Int2 p) const { return all_ >= 0 ? image_.Get(p, all_) : ofAll_; }
    /// Without a channel for it the first half has one more of an odd number.
    float First(Int2 p) const { return first_ >= 0 ? image_.Get(p, first_) : std::ceil(At(p) / 2); }
    float Second(Int2 p) const { return At(p) - First(p); }

  private:
    const Image& image_;
    int all_, first_;
    float ofAll_ = 0;
};

void ReadHalves(const Image& image, RenderBuffers* buffers) {
    int half[3];
    for (int c = 0; c < 3; ++c) half[c] = Channel(image, fmt::format("Half.{}", "RGB"[c]));
    const SampleCounts counts(image);
    const Int2 size = image.Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const float first = counts.First({x, y}), second = counts.Second({x, y});
            if (first < 1 || second < 1)
                throw std::invalid_argument(fmt::format(
                    "has {} and {} samples in the halves of pixel {}, {}; at least 1 is needed in each",
                    first, second, x, y));
            for (int c = 0; c < 3; ++c) {
                const float mean = image.Get({x, y}, c), a = image.Get({x, y}, half[c]);
                buffers->half[0].At(x, y)[size_t(c)] = a;
                buffers->half[1].At(x, y)[size_t(c)] = ((first + second) * mean - first * a) / second;
            }
        }
}

/// Variances of a half: the level from the differences of the halves around the pixel, the shape from the
/// samples of the pixel itself [Rousselle et al. 2012, sec. 5.1], within limits: next to a rare bright sample
/// the variances of others are small by comparison, and not in truth.
Color VariancesOf(const Image& image, const RenderBuffers& buffers) {
    const Int2 size = image.Resolution();
    const int sampleVariance = Channel(image, "Variance.Y");
    const SampleCounts counts(image);
    Color differences(size);
    Planes<1> shape(size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            // Of the variance s of a sample: s (1 / first + 1 / second) in the mean, where s / ((first +
            // second) / 2) is wanted.
            const float first = counts.First({x, y}), second = counts.Second({x, y});
            const float part = 2 * first * second / Sqr(first + second);
            for (size_t c = 0; c < 3; ++c)
                differences.At(x, y)[c] =
                    part * Sqr(buffers.half[0].At(x, y)[c] - buffers.half[1].At(x, y)[c]);
            shape.At(x, y)[0] = std::max(0.f, image.Get({x, y}, sampleVariance)) / counts.At({x, y});
        }
    const Color level = BoxMean(differences, kVarianceRadius);
    const Planes<1> mean = BoxMean(shape, kVarianceRadius);
    Color result(size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const float around = mean.At(x, y)[0];
            const float ratio = around > 0 ? shape.At(x, y)[0] / around : 1;
            for (size_t c = 0; c < 3; ++c)
                result.At(x, y)[c] = level.At(x, y)[c] * std::clamp(ratio, kMinShape, 1 / kMinShape);
        }
    return result;
}

/// Standard deviation of all depths, so that they are about as large as the other features.
float DepthScale(const Image& image, int channel) {
    double sum = 0, squares = 0;
    const Int2 size = image.Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const auto z = double(image.Get({x, y}, channel));
            sum += z;
            squares += z * z;
        }
    const double n = double(size.x) * size.y;
    const double variance = squares / n - (sum / n) * (sum / n);
    return variance > 0 ? float(1 / std::sqrt(variance)) : 0.f;
}

void ReadFeatures(const Image& image, RenderBuffers* buffers) {
    const Int2 size = image.Resolution();
    const SampleCounts counts(image);
    for (int i = 0; i < kNumFeatures; ++i) {
        const int mean = Channel(image, kFeatureChannels[i]);
        const int half = Channel(image, fmt::format("Half.{}", kFeatureChannels[i]));
        const float scale = i == kDepth ? DepthScale(image, mean) : 1.f;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const float value = scale * image.Get({x, y}, mean);
                buffers->features.At(x, y)[size_t(i)] = value;
                // Of a mean of two equal halves: the square of half of their difference.
                const float first = counts.First({x, y}), second = counts.Second({x, y});
                buffers->featureVariances.At(x, y)[size_t(i)] =
                    first / second * Sqr(scale * image.Get({x, y}, half) - value);
            }
    }
    buffers->featureVariances = BoxMean(buffers->featureVariances, 1);
}

}  // namespace

RenderBuffers BuffersOf(const Image& image) {
    if (!image.HasRGB()) throw std::invalid_argument("has no channels R, G and B");
    if (image.HasNonFinite()) throw std::invalid_argument("has values that are NaN or infinite");
    const Int2 size = image.Resolution();
    RenderBuffers buffers{{Color(size), Color(size)}, {}, Features(size), Features(size)};
    ReadHalves(image, &buffers);
    buffers.variance = VariancesOf(image, buffers);
    ReadFeatures(image, &buffers);
    return buffers;
}

}  // namespace lacquer::denoise
