// Adaptive sampling: which part of the samples of an image each pixel gets.
#pragma once

#include <cstdint>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// How many samples each pixel takes of those that an image has, in steps of an eighth of the mean.
///
/// Shares are fixed before the first sample that counts, so that any range of samples can be rendered by
/// itself: of the samples [first, end) of a pixel on average, a pixel with the share s takes
/// [ceil(s first), ceil(s end)) of its own.
class SampleShares {
  public:
    /// Shares are whole numbers of 1 / kUnit, from 1 to kMax.
    static constexpr int kUnit = 8, kMax = 128;
    /// No pixel takes more than this many times the mean.
    static constexpr int kMaxTimes = kMax / kUnit;

    SampleShares(const Bounds2i& pixels, std::vector<uint8_t> shares);

    const Bounds2i& PixelBounds() const { return pixels_; }
    /// In units of 1 / kUnit, rows from the top.
    const std::vector<uint8_t>& Shares() const { return shares_; }
    /// Where the samples of a pixel begin that are `samples` of an average one: monotone, and 0 for 0 alone.
    int64_t SamplesOf(Int2 pixel, int samples) const {
        return (int64_t(samples) * ShareOf(pixel) + kUnit - 1) / kUnit;
    }
    /// The samples of an average pixel that the first `taken` of this one are: at most, and at least.
    int MostOf(Int2 pixel, int64_t taken) const { return int(taken * kUnit / ShareOf(pixel)); }
    int LeastOf(Int2 pixel, int64_t taken) const {
        return taken > 0 ? int((taken - 1) * kUnit / ShareOf(pixel)) + 1 : 0;
    }
    /// Of the shares: the same for the same shares alone.
    uint64_t Fingerprint() const;

  private:
    int64_t ShareOf(Int2 pixel) const {
        const Int2 q = pixel - pixels_.min;
        return shares_[size_t(q.y) * size_t(pixels_.Width()) + size_t(q.x)];
    }

    Bounds2i pixels_;
    std::vector<uint8_t> shares_;
};

/// Shares in proportion to `density`, one positive number for each pixel, whose mean is one as far as the
/// limits allow.
SampleShares SharesInProportion(const Bounds2i& pixels, const std::vector<double>& density);

/// What pilot samples tell of a pixel.
struct PilotPixel {
    RGB mean{0};        ///< of two estimates
    RGB difference{0};  ///< of these
    float rays = 0;     ///< that one sample traces
};

/// The shares with which the mean over the pixels and channels of error^2 / (value^2 + e^2) is least for the
/// rays that are traced, e being a quarter of the image's mean: in proportion to sqrt(v / c), v being the
/// variance of one sample over value^2 + e^2 and c the rays that it traces [Neyman 1934].
///
/// v is the mean of the squared differences of pilots over a window around the pixel. The window is as large
/// as the differences in it could all be of one distribution: from 4 x 4 pixels it grows, and what the larger
/// one says is overruled by the smaller one only as far as they differ by more than two standard deviations.
/// So a single bright pilot draws no samples to itself. Memory: about 80 bytes a pixel while it runs.
SampleShares SharesByPilots(const Bounds2i& pixels, const std::vector<PilotPixel>& pilots);

}  // namespace lacquer
