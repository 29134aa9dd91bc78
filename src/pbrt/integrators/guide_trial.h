// Whether paths are worth guiding: whole sets of samples of a few pixels, with a guide and without.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "pbrt/base/integrator.h"

namespace lacquer {

/// Compares the variance of pixels with and without a guide: of each, by three sets of samples. Sets should
/// be as long as those of the image, for samplers spread the samples of a pixel evenly, and guided paths gain
/// less from that: by few samples a guide looks better than it is.
///
/// Sets have random numbers of other pixels: with those of the image, a guide would be taken where the
/// image's own samples happen to be bright, and the image would be too dark.
class GuideTrial {
  public:
    /// What a guide adds to the time of each path ray, in rays: as much as where vertices are cheap. By it
    /// and the rays that they take, guided samples last 1.35 times as long as others in a room lit through a
    /// door and 1.65 times in a Cornell box, where 1.2 and 1.6 was measured.
    static constexpr double kRaysOfDraw = 0.7;
    /// What an early look must find. Guides that came to gain 1.5 and more gained 1.2 to 2.2 by then, and
    /// those of a Cornell box, which are not worth their time, 0.7 to 1.25.
    static constexpr double kMinPromise = 1.1;

    /// Light of a set of samples: sums of red, green and blue.
    struct Set {
        glm::dvec3 first{0};             ///< without a guide, of those from which it will have learned
        glm::dvec3 rest{0};              ///< without a guide, of the others
        glm::dvec3 guided{0};            ///< of the others
        RayCounts rays{}, guidedRays{};  ///< of the others
    };
    /// How many samples sets have, and how many of these the guide learns from.
    struct Length {
        int samples = 0, learned = 0;
        /// False if they are too short to tell.
        bool IsEnough() const { return samples >= std::max(8, 2 * learned); }
        bool operator==(const Length&) const = default;
    };
    struct Gain {
        double value = 1;
        double logError = 0;  ///< standard error of its logarithm, by leaving out one pixel after the other
        double cost = 1;      ///< time of guided samples over that of others, by their rays
        /// What it is not below, two times in three.
        double AtLeast() const;
    };

    static constexpr int kSets = 3;

    /// Of one pixel in 200, 16 at least and 1024 at most.
    GuideTrial(Int2 resolution, int seed);

    size_t NumPixels() const { return pixels_.size(); }
    Int2 PixelAt(size_t k) const { return pixels_[k].place; }
    /// The pixel whose random numbers a set has: a quarter, a half or three quarters of the image further on.
    Int2 NumbersOf(size_t k, int set) const;
    /// Samples of a set, of which all sets take a twentieth of those of the image.
    /// @param samples  of a pixel of the image
    int MostSamples(int samples) const;
    /// Of the sets as they are; what they have without a guide serves another look at the same length.
    Length LengthOfSets() const { return length_; }
    void SetLength(Length length) { length_ = length; }
    /// For the one thread that has the pixel.
    Set& SetOf(size_t k, int number) { return pixels_[k].sets[size_t(number)]; }

    /// Variance without a guide over that of samples from which it learns, for which those without it stand,
    /// and guided ones together; of all channels relative to mean^2 + e^2, e being a quarter of the image's
    /// mean. One where neither has any; pixels with light that is no number are left out.
    Gain GainOfGuide() const;

  private:
    double CostOfGuide() const;

    struct Pixel {
        Int2 place{0};
        std::array<Set, kSets> sets;
    };

    Int2 resolution_;
    Length length_;
    std::vector<Pixel> pixels_;
};

}  // namespace lacquer
