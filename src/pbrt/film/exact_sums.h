// Sums that do not depend on the order of what they add.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lacquer {

/// Sums of floating-point numbers whose bits depend on the set of what was added alone: not on its order, and
/// not on how it was divided among sums that were added later.
///
/// The axis of exponents is cut into bins of 36 binary digits, fixed for good. Each number is rounded to the
/// two bins that begin at its own leading digit or above it, as two integers, and integers can be added in
/// any order. A sum keeps the two highest bins that any of its numbers reached and drops those below, whose
/// contents cannot have had any influence on these. This is the reproducible summation of [Demmel and Nguyen
/// 2015], with integers.
///
/// Range: all of a double's; a number is rounded to 2^-36 of the largest one of the sum or better, and what
/// is smaller counts as 0. At most 2^28 numbers for each sum. Numbers that are not finite count as 0.
/// Memory: 17 bytes for each sum. Several threads may add to different sums.
class ExactSums {
  public:
    explicit ExactSums(size_t count = 0) : bins_(count), levels_(count, kLowest) {}

    void Add(size_t i, double x) {
        double y = x * InverseUnit(levels_[i]);
        if (!(std::abs(y) < kLimit)) {
            if (!std::isfinite(x)) return;
            Raise(i, LevelOf(x));
            y = x * InverseUnit(levels_[i]);
        }
        const int64_t high = Nearest(y);
        bins_[i].high += high;
        bins_[i].low += Nearest((y - double(high)) * kBinSize);
    }
    /// Adds `other`, of the same size, sum by sum.
    void Add(const ExactSums& other);
    /// Adds sum number `from` of another one to sum number `to`.
    void Add(size_t to, const ExactSums& other, size_t from);
    /// The nearest double.
    double operator[](size_t i) const;
    size_t Size() const { return bins_.size(); }
    size_t Bytes() const { return bins_.size() * (sizeof(Bins) + sizeof(int8_t)); }

    /// For files: the integers and the levels, which mean nothing by themselves.
    static constexpr size_t kBinBytes = 2 * sizeof(int64_t);
    std::span<unsigned char> BinBytes() {
        return {reinterpret_cast<unsigned char*>(bins_.data()), bins_.size() * sizeof(Bins)};
    }
    std::span<unsigned char> LevelBytes() {
        return {reinterpret_cast<unsigned char*>(levels_.data()), levels_.size()};
    }
    bool HasValidLevels() const;

  private:
    /// A sum is (high + low / kBinSize) 2^(kBinWidth level).
    struct Bins {
        int64_t high = 0, low = 0;
    };
    static constexpr int kBinWidth = 36;
    static constexpr double kBinSize = double(int64_t(1) << kBinWidth);
    /// Numbers of a level are below this many of its units: then their part in the bin above it is 0.
    static constexpr double kLimit = kBinSize / 2;
    /// Levels whose units and their inverses are normal numbers; those beyond a double's range do not occur.
    static constexpr int kLowest = -28, kHighest = 28;

    /// 2^(-kBinWidth level).
    static double InverseUnit(int level) {
        constexpr int kBias = 1023, kMantissa = 52;
        return std::bit_cast<double>(uint64_t(kBias - kBinWidth * level) << kMantissa);
    }
    /// The nearest integer of |y| < 2^51; halves go to the even one.
    static int64_t Nearest(double y) {
        constexpr double kShift = 0x1.8p52;
        return std::bit_cast<int64_t>(y + kShift) - std::bit_cast<int64_t>(kShift);
    }
    /// The lowest level at which x, finite and not 0, is below kLimit.
    static int LevelOf(double x);
    void Raise(size_t i, int level);

    std::vector<Bins> bins_;
    std::vector<int8_t> levels_;
    static_assert(sizeof(Bins) == kBinBytes);
};

}  // namespace lacquer
