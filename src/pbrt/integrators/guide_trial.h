// Whether paths are worth guiding: whole sets of samples of a few pixels, with a guide and without.
#pragma once

#include <array>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Compares the variance of pixels with and without a guide: of each, by two sets of samples. Sets should be
/// as long as those of the image, for samplers spread the samples of a pixel evenly, and guided paths gain
/// less from that: by few samples a guide looks better than it is.
///
/// Sets have random numbers of other pixels: with those of the image, a guide would be taken where the
/// image's own samples happen to be bright, and the image would be too dark.
class GuideTrial {
  public:
    /// Time of a guided sample over that of another, of which 1.3 to 1.5 was measured.
    static constexpr double kCost = 1.5;
    /// What an early look must find, or nothing will come of it.
    static constexpr double kMinPromise = 1.15;

    /// Light of a set of samples: sums of red, green and blue.
    struct Set {
        glm::dvec3 first{0};   ///< without a guide, of those from which it has learned
        glm::dvec3 rest{0};    ///< without a guide, of the others
        glm::dvec3 guided{0};  ///< of the others
    };

    /// Of one pixel in 150, 16 at least and 1024 at most.
    GuideTrial(Int2 resolution, int seed);

    size_t NumPixels() const { return pixels_.size(); }
    Int2 PixelAt(size_t k) const { return pixels_[k].place; }
    /// The pixel whose random numbers a set has: half of the image away, to the side or up.
    Int2 NumbersOf(size_t k, int set) const {
        const Int2 offset = set == 0 ? Int2(resolution_.x / 2, 0) : Int2(0, resolution_.y / 2);
        return (PixelAt(k) + offset) % resolution_;
    }
    /// Samples of a set, of which all sets take a twentieth of those of the image.
    /// @param samples  of a pixel of the image
    int MostSamples(int samples) const;
    /// By the one thread that has the pixel. @param number  0 or 1
    void Add(size_t k, int number, const Set& set) { pixels_[k].sets[size_t(number)] = set; }

    /// Variance without a guide over that of samples from which it learns, for which those without it stand,
    /// and guided ones together; of all channels relative to mean^2 + e^2, e being a quarter of the image's
    /// mean. One where neither has any; pixels with light that is no number are left out.
    double Gain() const;

  private:
    struct Pixel {
        Int2 place{0};
        std::array<Set, 2> sets;
    };

    Int2 resolution_;
    std::vector<Pixel> pixels_;
};

}  // namespace lacquer
