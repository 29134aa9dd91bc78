#include "compare/box_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer {

namespace {

constexpr int kReplicates = 1000;
constexpr int kBlockSize = 4;
constexpr double kConfidence = 0.95;
/// The field's usual guard of relative errors in dark pixels.
constexpr float kRelativeEpsilon = 0.01f;
/// A reference that makes up more than this of an error leaves nothing to say about the rest.
constexpr double kLargestNoiseShare = 0.9999;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

const ColorSpace& SpaceOf(const Image& image) {
    return image.ColorSpace() ? *image.ColorSpace() : ColorSpace::SRGB();
}

/// The pixels of a box, block after block.
struct Blocks {
    std::vector<Int2> pixels;
    std::vector<size_t> ends;  ///< of each block, in `pixels`

    explicit Blocks(const Bounds2i& box) {
        for (int y0 = box.min.y; y0 < box.max.y; y0 += kBlockSize)
            for (int x0 = box.min.x; x0 < box.max.x; x0 += kBlockSize) {
                for (int y = y0; y < std::min(y0 + kBlockSize, box.max.y); ++y)
                    for (int x = x0; x < std::min(x0 + kBlockSize, box.max.x); ++x) pixels.push_back({x, y});
                ends.push_back(pixels.size());
            }
    }
};

/// What a resampling leaves of one estimator: means over the pixels drawn.
struct Means {
    double rootMeanSquare = 0, meanSquare = 0, relative = 0, noise = 0;

    double NoiseShare() const {
        return meanSquare > 0 ? std::clamp(noise / meanSquare, 0.0, kLargestNoiseShare) : 0;
    }
    double Corrected() const { return rootMeanSquare * std::sqrt(1 - NoiseShare()); }
};

/// All errors in one box.
class BoxErrors {
  public:
    BoxErrors(const Bounds2i& box, const Reference& reference, const std::vector<Runs>& runs)
        : blocks_(box), reference_(reference), numRuns_(runs[0].size()) {
        for (const Runs& ofOne : runs) {
            LACQUER_CHECK(ofOne.size() == numRuns_ && numRuns_ >= 1);
            Add(ofOne);
        }
        ReadNoise(runs);
    }

    size_t NumEstimators() const { return squares_.size(); }
    size_t NumRuns() const { return numRuns_; }
    size_t NumBlocks() const { return blocks_.ends.size(); }

    /// @param runWeights   sum to 1
    /// @param blockCounts  how often each block counts
    Means Resample(size_t estimator, const std::vector<float>& runWeights,
                   const std::vector<int>& blockCounts) const {
        Means means;
        double pixels = 0;
        size_t begin = 0;
        for (size_t b = 0; b < blockCounts.size(); ++b) {
            const size_t end = blocks_.ends[b];
            if (const double count = blockCounts[b]; count > 0) {
                const Means sums = SumsOf(estimator, runWeights, begin, end);
                means.rootMeanSquare += count * sums.rootMeanSquare;
                means.meanSquare += count * sums.meanSquare;
                means.relative += count * sums.relative;
                means.noise += count * sums.noise;
                pixels += count * double(end - begin);
            }
            begin = end;
        }
        for (double* m : {&means.rootMeanSquare, &means.meanSquare, &means.relative, &means.noise})
            *m /= pixels;
        return means;
    }

    /// Luminance; none with a single run.
    std::optional<BiasCheck> Bias(const Runs& runs) const {
        if (numRuns_ < 2) return std::nullopt;
        const ColorSpace& space = SpaceOf(*runs[0]);
        double difference = 0, brightness = 0, variance = 0;
        for (size_t p = 0; p < blocks_.pixels.size(); ++p) {
            const double r = Luminance(space, reference_.image, blocks_.pixels[p]);
            double mean = 0, m2 = 0;
            for (size_t i = 0; i < numRuns_; ++i) {
                const double delta = Luminance(space, *runs[i], blocks_.pixels[p]) - mean;
                mean += delta / double(i + 1);
                m2 += delta * (Luminance(space, *runs[i], blocks_.pixels[p]) - mean);
            }
            difference += mean - r;
            brightness += r;
            variance += m2 / double(numRuns_ - 1) / double(numRuns_);
        }
        // Pixels are independent, and so their variances add up; a noise that is only estimated can come out
        // below zero.
        const auto count = double(blocks_.pixels.size());
        variance += std::max(0.0, std::accumulate(luminanceNoise_.begin(), luminanceNoise_.end(), 0.0));
        return BiasCheck{difference / count, std::sqrt(variance) / count,
                         brightness > 0 ? difference / brightness : 0};
    }

  private:
    static double Luminance(const ColorSpace& space, const Image& image, Int2 p) {
        return double(space.Luminance({image.Get(p, 0), image.Get(p, 1), image.Get(p, 2)}));
    }

    void Add(const Runs& runs) {
        squares_.emplace_back(runs.size(), std::vector<float>(blocks_.pixels.size()));
        relative_.emplace_back(blocks_.pixels.size(), 0.f);
        for (size_t i = 0; i < runs.size(); ++i)
            for (size_t p = 0; p < blocks_.pixels.size(); ++p) {
                float square = 0, relative = 0;
                for (int c = 0; c < 3; ++c) {
                    const float r = reference_.image.Get(blocks_.pixels[p], c);
                    const float s = Sqr(runs[i]->Get(blocks_.pixels[p], c) - r);
                    square += s / 3;
                    relative += s / (Sqr(r) + kRelativeEpsilon) / 3;
                }
                squares_.back()[i][p] = square;
                relative_.back()[p] += relative / float(runs.size());
            }
    }

    /// Variance of the reference in each pixel: its own figure, or from products of errors of different runs.
    void ReadNoise(const std::vector<Runs>& runs) {
        noise_.assign(blocks_.pixels.size(), 0.f);
        luminanceNoise_.assign(blocks_.pixels.size(), 0.0);
        const bool isKnown = reference_.NoiseIsKnown();
        if (!isKnown && runs.size() * numRuns_ < 2) return;
        const int first = isKnown ? reference_.image.FindChannel(NoiseChannels()[0]) : 0;
        for (size_t p = 0; p < blocks_.pixels.size(); ++p) {
            const Int2 pixel = blocks_.pixels[p];
            if (isKnown) {
                for (int c = 0; c < 3; ++c) noise_[p] += reference_.image.Get(pixel, first + c) / 3;
                luminanceNoise_[p] = double(reference_.image.Get(pixel, first + 3));
            } else {
                EstimateNoise(runs, p);
            }
        }
    }

    /// For n independent x_i of one mean, the mean of (x_i - r)(x_j - r) over i != j is (mean - r)^2.
    void EstimateNoise(const std::vector<Runs>& runs, size_t p) {
        const ColorSpace& space = SpaceOf(*runs[0][0]);
        const Int2 pixel = blocks_.pixels[p];
        double sum[4] = {}, squares[4] = {}, n = 0;
        for (const Runs& ofOne : runs)
            for (const Image* image : ofOne) {
                const double errors[4] = {
                    double(image->Get(pixel, 0)) - double(reference_.image.Get(pixel, 0)),
                    double(image->Get(pixel, 1)) - double(reference_.image.Get(pixel, 1)),
                    double(image->Get(pixel, 2)) - double(reference_.image.Get(pixel, 2)),
                    Luminance(space, *image, pixel) - Luminance(space, reference_.image, pixel)};
                for (int c = 0; c < 4; ++c) {
                    sum[c] += errors[c];
                    squares[c] += errors[c] * errors[c];
                }
                ++n;
            }
        const auto meanProduct = [&](int c) { return (sum[c] * sum[c] - squares[c]) / (n * (n - 1)); };
        noise_[p] = float((meanProduct(0) + meanProduct(1) + meanProduct(2)) / 3);
        luminanceNoise_[p] = meanProduct(3);
    }

    Means SumsOf(size_t estimator, const std::vector<float>& runWeights, size_t begin, size_t end) const {
        Means sums;
        for (size_t p = begin; p < end; ++p) {
            float square = 0;
            for (size_t i = 0; i < numRuns_; ++i) square += runWeights[i] * squares_[estimator][i][p];
            sums.rootMeanSquare += double(std::sqrt(square));
            sums.meanSquare += double(square);
            sums.relative += double(relative_[estimator][p]);
            sums.noise += double(noise_[p]);
        }
        return sums;
    }

    Blocks blocks_;
    const Reference& reference_;
    size_t numRuns_;
    std::vector<std::vector<std::vector<float>>> squares_;  ///< [estimator][run][pixel]
    std::vector<std::vector<float>> relative_;              ///< [estimator][pixel], mean over the runs
    std::vector<float> noise_;
    std::vector<double> luminanceNoise_;
};

/// How often each of `count` things comes up in `count` draws.
std::vector<int> DrawWithReplacement(size_t count, Rng& rng) {
    std::vector<int> drawn(count, 0);
    for (size_t i = 0; i < count; ++i) ++drawn[rng.UniformInt(uint32_t(count))];
    return drawn;
}

/// Replicates of all estimators. [estimator][replicate]
std::vector<std::vector<Means>> Bootstrap(const BoxErrors& errors, uint64_t seed) {
    std::vector<std::vector<Means>> replicates(errors.NumEstimators(), std::vector<Means>(kReplicates));
    ParallelFor(kReplicates, [&](int64_t replicate) {
        Rng rng(Hash(seed, replicate));
        std::vector<float> weights;
        for (const int drawn : DrawWithReplacement(errors.NumRuns(), rng))
            weights.push_back(float(drawn) / float(errors.NumRuns()));
        const std::vector<int> blocks = DrawWithReplacement(errors.NumBlocks(), rng);
        for (size_t e = 0; e < replicates.size(); ++e)
            replicates[e][size_t(replicate)] = errors.Resample(e, weights, blocks);
    });
    return replicates;
}

/// Interval around `value` from replicates of it; see MeasureBox.
Interval IntervalOf(double value, const std::vector<double>& replicates, double stretch) {
    if (!(value > 0) || !std::isfinite(value)) return {value, value, value};
    std::vector<double> logs;
    for (const double replicate : replicates)
        if (replicate > 0 && std::isfinite(replicate)) logs.push_back(std::log(replicate));
    if (logs.size() < replicates.size() / 2) return {value, kNotANumber, kNotANumber};
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / double(logs.size());
    std::sort(logs.begin(), logs.end());
    const auto quantile = [&](double q) {
        return logs[size_t(std::lround(q * double(logs.size() - 1)))] - mean;
    };
    const double tail = (1 - kConfidence) / 2;
    return {value, value * std::exp(stretch * quantile(tail)),
            value * std::exp(stretch * quantile(1 - tail))};
}

Interval Squared(const Interval& x) { return {Sqr(x.value), Sqr(x.low), Sqr(x.high)}; }

/// `statistic` of each replicate.
template <class Statistic>
std::vector<double> Each(const Statistic& statistic) {
    std::vector<double> values(kReplicates);
    for (size_t i = 0; i < values.size(); ++i) values[i] = statistic(i);
    return values;
}

double Ratio(double a, double b) { return b > 0 ? a / b : kNotANumber; }

}  // namespace

std::vector<BoxResult> MeasureBox(const Bounds2i& pixels, const Reference& reference,
                                  const std::vector<Runs>& runs, size_t baseline, uint64_t seed) {
    const BoxErrors errors(pixels, reference, runs);
    const std::vector<std::vector<Means>> replicates = Bootstrap(errors, seed);
    const std::vector<float> evenly(errors.NumRuns(), 1 / float(errors.NumRuns()));
    const std::vector<int> once(errors.NumBlocks(), 1);
    std::vector<Means> measured;
    for (size_t e = 0; e < runs.size(); ++e) measured.push_back(errors.Resample(e, evenly, once));

    const auto n = double(errors.NumRuns());
    const double stretch = n > 1 ? std::sqrt(n / (n - 1)) : 1;
    std::vector<BoxResult> results;
    for (size_t e = 0; e < runs.size(); ++e) {
        const auto replicate = [&](size_t which, size_t i) -> const Means& { return replicates[which][i]; };
        BoxResult r;
        r.rmse = IntervalOf(measured[e].rootMeanSquare,
                            Each([&](size_t i) { return replicate(e, i).rootMeanSquare; }), stretch);
        r.relativeMse = IntervalOf(measured[e].relative,
                                   Each([&](size_t i) { return replicate(e, i).relative; }), stretch);
        r.rmseCorrected = measured[e].Corrected();
        r.referenceNoise = measured[e].noise;
        r.referenceNoiseShare = measured[e].NoiseShare();
        r.bias = errors.Bias(runs[e]);
        const auto reduction = [](const Means& base, const Means& other) {
            return Ratio(base.Corrected(), other.Corrected());
        };
        r.rmseReduction = IntervalOf(
            reduction(measured[baseline], measured[e]),
            Each([&](size_t i) { return reduction(replicate(baseline, i), replicate(e, i)); }), stretch);
        r.timeReduction = Squared(r.rmseReduction);
        results.push_back(r);
    }
    return results;
}

double RmseOfSums(const std::vector<float>& sums, int width, const Bounds2i& pixels, int runs, double noise) {
    Means means;
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
        for (int x = pixels.min.x; x < pixels.max.x; ++x) {
            const double square = double(sums[size_t(y) * size_t(width) + size_t(x)]) / runs;
            means.rootMeanSquare += std::sqrt(square) / double(pixels.Area());
            means.meanSquare += square / double(pixels.Area());
        }
    means.noise = noise;
    return means.Corrected();
}

std::vector<float> SquaredErrors(const Image& image, const Image& reference) {
    const Int2 size = image.Resolution();
    std::vector<float> errors(size_t(size.x) * size_t(size.y));
    size_t i = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x, ++i)
            for (int c = 0; c < 3; ++c) errors[i] += Sqr(image.Get({x, y}, c) - reference.Get({x, y}, c)) / 3;
    return errors;
}

}  // namespace lacquer
