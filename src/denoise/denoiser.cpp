#include "denoise/denoiser.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "denoise/regression.h"
#include "pbrt/core/math.h"

namespace lacquer::denoise {
namespace {

constexpr PatchOptions kFeatureFilter{.windowRadius = 5, .patchRadius = 3, .bandwidth = 1};
/// Of the maps that choose between the candidates.
constexpr PatchOptions kErrorFilter{.windowRadius = 5, .patchRadius = 3, .bandwidth = 1};

/// Features by non-local means, and what is left of their variance.
struct SmoothFeatures {
    Features values, variances;
};
SmoothFeatures Smooth(const RenderBuffers& buffers) {
    const Guide<kNumFeatures> guide{buffers.features, buffers.featureVariances};
    SmoothFeatures smooth{WeightedMeans(buffers.features, guide, kFeatureFilter), buffers.featureVariances};
    // A window of 100 pixels leaves a tenth where it could average, and all at edges; the truth is between.
    for (auto& v : smooth.variances.All())
        for (float& x : v) x *= 0.25f;
    return smooth;
}

/// One of the images between which the estimated error decides in each pixel.
struct Candidate {
    Color color;
    Planes<1> error;  ///< squared error, but for a constant of the pixel
    Planes<1> noise;  ///< variance alone
};
/// @param filtered  both halves: each depends on the values of one half, and on the other one by weights only
Candidate Combine(const Color (&filtered)[2], const RenderBuffers& buffers) {
    const Int2 size = buffers.features.Size();
    Candidate candidate{Color(size), Planes<1>(size), Planes<1>(size)};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            float error = 0, noise = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float a = filtered[0].At(x, y)[c], b = filtered[1].At(x, y)[c];
                const float A = buffers.half[0].At(x, y)[c], B = buffers.half[1].At(x, y)[c];
                // E (F(A) - B)^2 is the error of F(A) and the variance of B, which is the same for all
                // candidates: it is left, since what (A - B)^2 says of it is wrong where the halves know of
                // each other, as those of low-discrepancy samples do. The mean of a and b has less variance
                // than each.
                error += 0.5f * (Sqr(a - B) + Sqr(b - A)) - 0.25f * Sqr(a - b);
                noise += 0.25f * Sqr(a - b);
                candidate.color.At(x, y)[c] = 0.5f * (a + b);
            }
            candidate.error.At(x, y)[0] = error / 3;
            candidate.noise.At(x, y)[0] = noise / 3;
        }
    return candidate;
}

Candidate Filter(const RenderBuffers& buffers, const SmoothFeatures& features, float bandwidth,
                 const DenoiseOptions& options) {
    const PatchOptions patches{
        .windowRadius = options.windowRadius, .patchRadius = 3, .bandwidth = bandwidth};
    Color filtered[2];
    for (int h = 0; h < 2; ++h)
        filtered[h] = Regress(buffers.half[h], {buffers.half[1 - h], buffers.variance}, features.values,
                              features.variances, patches, options.observer);
    return Combine(filtered, buffers);
}

/// Estimates of single pixels are mostly noise: they are averaged over pixels that look alike.
template <size_t N>
Planes<N> SmoothError(const Planes<N>& error, const RenderBuffers& buffers) {
    Color guide(error.Size());
    for (int y = 0; y < error.Size().y; ++y)
        for (int x = 0; x < error.Size().x; ++x)
            for (size_t c = 0; c < 3; ++c)
                guide.At(x, y)[c] = 0.5f * (buffers.half[0].At(x, y)[c] + buffers.half[1].At(x, y)[c]);
    return WeightedMeans(error, Guide<3>{guide, buffers.variance}, kErrorFilter);
}

constexpr size_t kNumCandidates = 3;

/// How much of each candidate a pixel gets: the one of the least estimated error, as a map of 0 and 1,
/// smoothed so that no edges appear where they change.
Planes<kNumCandidates> SharesOf(const std::array<Candidate, kNumCandidates>& candidates,
                                const RenderBuffers& buffers) {
    std::array<Planes<1>, kNumCandidates> errors;
    for (size_t k = 0; k < kNumCandidates; ++k) errors[k] = SmoothError(candidates[k].error, buffers);
    Planes<kNumCandidates> shares(buffers.features.Size());
    for (size_t i = 0; i < shares.All().size(); ++i) {
        size_t best = 0;
        for (size_t k = 1; k < kNumCandidates; ++k)
            if (errors[k].All()[i][0] < errors[best].All()[i][0]) best = k;
        shares.All()[i][best] = 1;
    }
    return SmoothError(shares, buffers);
}

}  // namespace

Denoised Denoise(const RenderBuffers& buffers, const DenoiseOptions& options) {
    const Int2 size = buffers.features.Size();
    if (options.observer) options.observer->Begin("denoising", 4 * int64_t(size.x) * size.y, "pixels");
    const SmoothFeatures features = Smooth(buffers);
    // The colours as they are come last: what no filter makes better shall stay.
    const std::array<Candidate, kNumCandidates> candidates{
        Filter(buffers, features, options.bandwidths[0], options),
        Filter(buffers, features, options.bandwidths[1], options), Combine(buffers.half, buffers)};
    const Planes<kNumCandidates> shares = SharesOf(candidates, buffers);
    Denoised result{Color(size), Planes<1>(size)};
    double squares = 0;
    for (size_t i = 0; i < shares.All().size(); ++i) {
        for (size_t k = 0; k < kNumCandidates; ++k) {
            const float share = shares.All()[i][k];
            for (size_t c = 0; c < 3; ++c)
                result.color.All()[i][c] += share * candidates[k].color.All()[i][c];
            result.noise.All()[i][0] += share * candidates[k].noise.All()[i][0];
        }
        squares += double(result.noise.All()[i][0]);
    }
    result.noise = SmoothError(result.noise, buffers);
    result.noiseAfter = float(std::sqrt(squares / double(shares.All().size())));
    double noise = 0;
    for (size_t i = 0; i < shares.All().size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            noise += double(Sqr(buffers.half[0].All()[i][c] - buffers.half[1].All()[i][c])) / 12;
    result.noiseBefore = float(std::sqrt(noise / double(shares.All().size())));
    if (options.observer) options.observer->End();
    return result;
}

void SetColors(const Color& color, Image* image) {
    const Int2 size = image->Resolution();
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 3; ++c) image->Set({x, y}, c, color.At(x, y)[size_t(c)]);
}

}  // namespace lacquer::denoise
