// How much less noise one estimator has than another, and how sure that is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lacquer::bench {

/// Sums over the estimates of one estimator, for each of several pairs of directions, kept in blocks: the
/// data that the bootstrap draws from. Rounds of measurements go to the blocks in turn, so that slow drift of
/// the machine is in all of them alike.
class NoiseSums {
  public:
    static constexpr size_t kBlocks = 64;

    explicit NoiseSums(size_t numPairs) : cells_(numPairs * kBlocks), numPairs_(numPairs) {}

    /// `count` estimates of one pair, their sum and the sum of their squares.
    void Add(size_t block, size_t pair, double count, double sum, double squares);
    /// CPU time [s] of all estimates that a round made.
    void AddTime(size_t block, double seconds) { seconds_[block] += seconds; }

    size_t NumPairs() const { return numPairs_; }

    struct Cell {
        double count = 0, sum = 0, squares = 0;
    };
    const Cell& At(size_t block, size_t pair) const { return cells_[pair * kBlocks + block]; }
    double Seconds(size_t block) const { return seconds_[block]; }

  private:
    std::vector<Cell> cells_;
    size_t numPairs_;
    std::array<double, kBlocks> seconds_{};
};

/// How often each pair and each block counts: 1 for the measurement itself, random for a bootstrap's replica.
struct Multiplicity {
    std::vector<double> pairs;
    std::array<double, NoiseSums::kBlocks> blocks;
};
Multiplicity Once(size_t numPairs);

/// What a measurement says about one estimator.
struct Noise {
    double seconds = 0;    ///< of one estimate
    double mean = 0;       ///< of the estimates, over all pairs
    double rms = 0;        ///< root over the mean over pairs of the variance of one estimate
    double relative = 0;   ///< mean over pairs of standard deviation / mean, where there is a mean
    double meanError = 0;  ///< standard error of `mean` for these pairs

    double RelativeRms() const { return mean > 0 ? rms / mean : 0; }
    /// Noise below the rounding of a float: known without any.
    bool IsExact() const { return rms <= kRounding * mean; }
    static constexpr double kRounding = 3e-7;
};
/// `rms` and `relative` are at least a float's rounding, so that ratios of noise stay finite.
Noise NoiseOf(const NoiseSums& sums, const Multiplicity& multiplicity);

/// Logarithms of quotients of the errors (RMSE) of a baseline over those of a candidate: positive where the
/// candidate is better. Equal samples: of one estimate each. Equal time: times the root of the quotient of
/// their times, since error falls with the root of the number of samples.
struct LogRatios {
    double samples = 0, time = 0;                  ///< by Noise::rms
    double relativeSamples = 0, relativeTime = 0;  ///< by Noise::relative

    /// Of one candidate against another that had the same baseline.
    friend LogRatios operator-(const LogRatios& a, const LogRatios& b) {
        return {a.samples - b.samples, a.time - b.time, a.relativeSamples - b.relativeSamples,
                a.relativeTime - b.relativeTime};
    }
};
LogRatios LogRatiosOf(const Noise& baseline, const Noise& candidate);

/// What a bootstrap draws anew. Pairs: would other directions say the same? Samples: would other random
/// numbers and another run of the clock?
enum class Resampling { Pairs, Samples, Both };

/// Replicas of LogRatiosOf() with pairs or blocks or both drawn with replacement, the same for both
/// estimators [Efron 1979]. Both must have the same pairs. Cost: replicas * pairs * blocks.
std::vector<LogRatios> Bootstrap(const NoiseSums& baseline, const NoiseSums& candidate, Resampling resampling,
                                 int numReplicas, uint64_t seed);

struct Interval {
    double low = 0, high = 0;
    bool Contains(double x) const { return low <= x && x <= high; }
};
/// The central interval that holds the fraction `confidence` of the values; not empty.
Interval CentralInterval(std::vector<double> values, double confidence);

/// exp(mean of logarithms); 1 for none.
double GeometricMean(std::span<const double> logs);

}  // namespace lacquer::bench
