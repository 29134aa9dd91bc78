// The cosines that one reflection by an isotropic rough boundary turns a cosine into.
//
// A direction with cosine c is described by x = sqrt(1 - c) in [0, 1]: near 0 that is proportional to the
// angle, and equal steps of x keep lobes about equally wide. For given x before the reflection the table
// holds quantiles of x after it, light that Fresnel's factor takes away not regarded.
#pragma once

#include <array>

#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// Quantiles over (alpha, x). What is made of them serves as a density to draw from: errors of the table cost
/// noise, never bias. About 60 kB; constant once made.
class ReflectionQuantiles {
  public:
    static constexpr int kNumCells = 32;
    /// The upper ends of the cells, rising, in [0, 1]; the lower end of the first one is 0, the upper end of
    /// the last one 1.
    struct alignas(64) Row {
        std::array<float, kNumCells> ends;
    };

    /// Probability of each cell. They get smaller towards both ends, by a factor of ten: what is rare in one
    /// reflection is what long paths live on.
    static const std::array<float, kNumCells>& Masses();
    /// The table of a distribution of facets; made at first use, in 40 ms (Beckmann) or 5 ms.
    template <MicrofacetDistribution Distribution>
    static const ReflectionQuantiles& Of();

    /// The rows of one alpha: two of the table's and where between them. Alphas out of [0.02, 0.9] get the
    /// nearest one's.
    class Slice {
      public:
        /// The cells of x after the reflection; x in [0, 1] is that before it.
        Row Find(float x) const;

      private:
        friend class ReflectionQuantiles;
        const Row *low_, *high_;
        float share_;  ///< of high_
    };
    Slice At(float alpha) const;

  private:
    static constexpr int kNumRows = 33, kNumAlphas = 12;
    static constexpr float kFirstAlpha = 0.02f, kAlphasPerOctave = 2;

    ReflectionQuantiles() = default;

    std::array<std::array<Row, kNumRows>, kNumAlphas> rows_;
};

extern template const ReflectionQuantiles& ReflectionQuantiles::Of<Beckmann>();
extern template const ReflectionQuantiles& ReflectionQuantiles::Of<TrowbridgeReitz>();

}  // namespace lacquer::layered
