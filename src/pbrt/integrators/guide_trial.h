// Whether paths are worth guiding: samples of the same pixels, some of them with a guide and some without.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace lacquer {

/// Adds up the variance of means with and without a guide, of each tile relative to the square of its mean:
/// of two means of each, over blocks of samples that follow each other, since it is such blocks that samplers
/// spread evenly, and what is smooth gains more by that. In integers, so that it does not depend on threads.
class GuideTrial {
  public:
    /// Samples of one pixel.
    class Pixel {
      public:
        /// @param block  two of each way
        void Add(bool isGuided, int block, float light) {
            Mean& mean = means_[size_t(isGuided)][size_t(block)];
            ++mean.count;
            mean.sum += double(light);
        }

      private:
        friend class GuideTrial;
        struct Mean {
            int count = 0;
            double sum = 0;
            double Value() const { return sum / count; }
        };
        using Means = std::array<Mean, 2>;

        static double MeanOf(const Means& m) { return (m[0].Value() + m[1].Value()) / 2; }
        static double VarianceOf(const Means& m) {
            const double difference = m[0].Value() - m[1].Value();
            return difference * difference / 2;
        }
        std::array<Means, 2> means_;
    };
    /// Of pixels with alike numbers of samples.
    class Tile {
      public:
        void Add(const Pixel& pixel) {
            const double mean = (Pixel::MeanOf(pixel.means_[0]) + Pixel::MeanOf(pixel.means_[1])) / 2;
            if (!std::isfinite(mean)) return;
            ++count_;
            mean_ += mean;
            for (size_t i = 0; i < 2; ++i) variances_[i] += Pixel::VarianceOf(pixel.means_[i]);
        }

      private:
        friend class GuideTrial;
        int count_ = 0;
        double mean_ = 0;  ///< and variances: of all pixels together
        std::array<double, 2> variances_{};
    };

    /// By any thread.
    void Add(const Tile& tile) {
        if (!(tile.mean_ > 0)) return;
        const double unit = tile.count_ * kUnits / (tile.mean_ * tile.mean_);
        for (size_t i = 0; i < 2; ++i)
            std::atomic_ref(variances_[i])
                .fetch_add(int64_t(tile.variances_[i] * unit * tile.count_), std::memory_order_relaxed);
    }
    /// True as well if nothing was added.
    bool IsWorthIt() const { return double(variances_[0]) >= kCost * double(variances_[1]); }

  private:
    static constexpr double kUnits = 0x1p20;
    /// Time of a guided sample over that of another, of which 1.4 to 1.6 was measured, times what samplers
    /// gain where light is smooth by more samples than a block has.
    static constexpr double kCost = 2.5;

    std::array<int64_t, 2> variances_{};
};

}  // namespace lacquer
