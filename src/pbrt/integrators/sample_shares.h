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

    /// In units of 1 / kUnit, rows from the top.
    const std::vector<uint8_t>& Shares() const { return shares_; }
    /// Where the samples of a pixel begin that are `samples` of an average one: monotone, and 0 for 0 alone.
    int64_t SamplesOf(Int2 pixel, int samples) const { return SamplesOfShare(ShareOf(pixel), samples); }
    /// The samples of an average pixel that the first `taken` of this one are: at most, and at least.
    int MostOf(Int2 pixel, int64_t taken) const { return int(taken * kUnit / ShareOf(pixel)); }
    int LeastOf(Int2 pixel, int64_t taken) const {
        return taken > 0 ? int((taken - 1) * kUnit / ShareOf(pixel)) + 1 : 0;
    }
    /// The fewest that any pixel takes of the samples [first, end) of an average one.
    int64_t FewestOf(int first, int end) const;
    /// True if all pixels get the same.
    bool AreEven() const;
    /// Of the shares: the same for the same shares alone.
    uint64_t Fingerprint() const;

  private:
    static int64_t SamplesOfShare(int64_t share, int samples) {
        return (int64_t(samples) * share + kUnit - 1) / kUnit;
    }
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
    float cost = 0;     ///< of one sample, in that of a ray
};

/// Shares for a small mean over the pixels and channels of error^2 / (value^2 + e^2) for the time that it
/// takes, e being a quarter of the image's mean: in proportion to (v / c)^0.4 or (v / c)^0.2, v being the
/// variance of an estimate over value^2 + e^2 and c the cost of a sample. With independent samples
/// (v / c)^0.5 would be best [Neyman 1934]; well distributed ones need fewer more. All get the same if shares
/// that follow from the pilots around each pixel, without its own, would gain less than a twentieth by what
/// its own tell.
///
/// v is the geometric mean, over windows of 4 x 4 to 32 x 32 pilots around the pixel, of the mean squares of
/// |difference| in them, of 1024 at most, each of a quarter of the next larger one at least. A bright pilot
/// draws samples to its surroundings, for rare bright samples have most of the error where they are: to some
/// 30 x 30 pilots, and as many as these had before. Memory: about 70 bytes a pilot, and 10 a pixel, while it
/// runs.
/// @param spacing  side of the blocks of pixels, of each of which `pilots` has one
SampleShares SharesByPilots(const Bounds2i& pixels, int spacing, const std::vector<PilotPixel>& pilots);

/// How many blocks of spacing x spacing pixels there are, those at the edges included.
inline Int2 PilotBlocksOf(const Bounds2i& pixels, int spacing) {
    return (Int2(pixels.Width(), pixels.Height()) + (spacing - 1)) / spacing;
}

}  // namespace lacquer
