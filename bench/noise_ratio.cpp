#include "noise_ratio.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pbrt/core/check.h"
#include "pbrt/core/rng.h"

namespace lacquer::bench {

void NoiseSums::Add(size_t block, size_t pair, double count, double sum, double squares) {
    Cell& cell = cells_[pair * kBlocks + block];
    cell.count += count;
    cell.sum += sum;
    cell.squares += squares;
}

Multiplicity Once(size_t numPairs) {
    Multiplicity once{std::vector<double>(numPairs, 1), {}};
    once.blocks.fill(1);
    return once;
}

Noise NoiseOf(const NoiseSums& sums, const Multiplicity& multiplicity) {
    Noise noise;
    double numEstimates = 0, numPairs = 0, numRelative = 0, sumVariance = 0, sumError2 = 0;
    for (size_t pair = 0; pair < sums.NumPairs(); ++pair) {
        const double times = multiplicity.pairs[pair];
        double count = 0, sum = 0, squares = 0;
        for (size_t block = 0; block < NoiseSums::kBlocks; ++block) {
            const NoiseSums::Cell& cell = sums.At(block, pair);
            count += multiplicity.blocks[block] * cell.count;
            sum += multiplicity.blocks[block] * cell.sum;
            squares += multiplicity.blocks[block] * cell.squares;
        }
        // Each pair has the same share of the time, whether this replica counts it or not.
        numEstimates += count;
        if (!(times > 0 && count > 1)) continue;
        const double mean = sum / count, variance = std::max(0., squares - sum * mean) / (count - 1);
        numPairs += times;
        noise.mean += times * mean;
        sumVariance += times * variance;
        sumError2 += times * variance / count;
        if (!(mean > 0)) continue;
        noise.relative += times * std::max(std::sqrt(variance) / mean, Noise::kRounding);
        numRelative += times;
    }
    double seconds = 0;
    for (size_t block = 0; block < NoiseSums::kBlocks; ++block)
        seconds += multiplicity.blocks[block] * sums.Seconds(block);

    if (numEstimates > 0) noise.seconds = seconds / numEstimates;
    if (numRelative > 0) noise.relative /= numRelative;
    if (numPairs > 0) {
        noise.mean /= numPairs;
        noise.rms = std::max(std::sqrt(sumVariance / numPairs), Noise::kRounding * noise.mean);
        noise.meanError = std::sqrt(sumError2) / numPairs;
    }
    return noise;
}

LogRatios LogRatiosOf(const Noise& baseline, const Noise& candidate) {
    const auto logOf = [](double a, double b) { return a > 0 && b > 0 ? std::log(a / b) : 0; };
    const double halfTime = 0.5 * logOf(baseline.seconds, candidate.seconds);
    const double rms = logOf(baseline.rms, candidate.rms);
    const double relative = logOf(baseline.relative, candidate.relative);
    return {rms, rms + halfTime, relative, relative + halfTime};
}

namespace {

/// As many draws with replacement as there are entries.
void SampleMultiplicities(std::span<double> times, Rng& rng) {
    std::fill(times.begin(), times.end(), 0.);
    for (size_t i = 0; i < times.size(); ++i) ++times[rng.UniformInt(uint32_t(times.size()))];
}

}  // namespace

std::vector<LogRatios> Bootstrap(const NoiseSums& baseline, const NoiseSums& candidate, Resampling resampling,
                                 int numReplicas, uint64_t seed) {
    LACQUER_CHECK(baseline.NumPairs() == candidate.NumPairs());
    Rng rng(Hash(seed));
    Multiplicity multiplicity = Once(baseline.NumPairs());
    std::vector<LogRatios> replicas;
    for (int i = 0; i < numReplicas; ++i) {
        if (resampling != Resampling::Samples) SampleMultiplicities(multiplicity.pairs, rng);
        if (resampling != Resampling::Pairs) SampleMultiplicities(multiplicity.blocks, rng);
        replicas.push_back(LogRatiosOf(NoiseOf(baseline, multiplicity), NoiseOf(candidate, multiplicity)));
    }
    return replicas;
}

Interval CentralInterval(std::vector<double> values, double confidence) {
    LACQUER_CHECK(!values.empty() && confidence > 0 && confidence < 1);
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double q) {
        const double at = q * double(values.size() - 1);
        const size_t below = size_t(at), above = std::min(below + 1, values.size() - 1);
        return std::lerp(values[below], values[above], at - double(below));
    };
    return {quantile((1 - confidence) / 2), quantile((1 + confidence) / 2)};
}

double GeometricMean(std::span<const double> logs) {
    if (logs.empty()) return 1;
    return std::exp(std::accumulate(logs.begin(), logs.end(), 0.) / double(logs.size()));
}

}  // namespace lacquer::bench
