#include "compare/box_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "compare/metrics.h"
#include "compare/running_variance.h"
#include "pbrt/core/check.h"
#include "pbrt/core/multiple_tests.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::compare {

namespace {

constexpr int kReplicates = 1000;
constexpr int kBlockSize = 4;
constexpr double kConfidence = 0.95;
/// With less of them nothing can be said about how they go together.
constexpr size_t kMinBlocks = 8;

/// A reference that makes up more than this of an error leaves too little to say anything about the rest.
constexpr double kLargestNoiseShare = 0.5;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Averaged over R, G and B.
float SquaredError(const Image& image, const Image& reference, Int2 p) {
    float square = 0;
    for (int c = 0; c < 3; ++c) square += Sqr(image.Get(p, c) - reference.Get(p, c)) / 3;
    return square;
}
/// The same relative to the reference.
float RelativeSquaredError(const Image& image, const Image& reference, Int2 p) {
    float relative = 0;
    for (int c = 0; c < 3; ++c) {
        const float r = reference.Get(p, c);
        relative += Sqr(image.Get(p, c) - r) / (Sqr(r) + float(kRelativeEpsilon)) / 3;
    }
    return relative;
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

    double NoiseShare() const { return meanSquare > 0 ? std::clamp(noise / meanSquare, 0.0, 1.0) : 0; }
    /// Not a number where the reference is too noisy.
    double Corrected() const {
        const double share = NoiseShare();
        return share > kLargestNoiseShare ? kNotANumber : rootMeanSquare * std::sqrt(1 - share);
    }
};

/// A resampling of a box.
struct Resampling {
    std::vector<int> blocks;        ///< how often each block counts
    std::vector<float> runWeights;  ///< [block][run], summing to 1 in each block
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

    /// @param drawing  how often each block and each of its runs counts
    Means Resample(size_t estimator, const Resampling& resampling) const {
        Means means;
        double pixels = 0;
        size_t begin = 0;
        for (size_t b = 0; b < NumBlocks(); ++b) {
            const size_t end = blocks_.ends[b];
            if (const double count = resampling.blocks[b]; count > 0) {
                const Means sums = SumsOf(estimator, &resampling.runWeights[b * numRuns_], begin, end);
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

    /// Between the runs of an estimator, the variance of the squared error of the whole box over what it
    /// would be if blocks were independent. 1 with a single run.
    double SharedVariance(size_t estimator) const {
        if (numRuns_ < 2) return 1;
        std::vector<double> ofBox(numRuns_, 0.0);
        double ofBlocks = 0;
        size_t begin = 0;
        for (const size_t end : blocks_.ends) {
            RunningVariance runs;
            for (size_t i = 0; i < numRuns_; ++i) {
                const std::vector<float>& squares = squares_[estimator][i];
                const double sum = std::accumulate(squares.begin() + std::ptrdiff_t(begin),
                                                   squares.begin() + std::ptrdiff_t(end), 0.0);
                runs.Add(sum);
                ofBox[i] += sum;
            }
            ofBlocks += runs.Variance();
            begin = end;
        }
        RunningVariance runs;
        for (const double sum : ofBox) runs.Add(sum);
        return ofBlocks > 0 ? runs.Variance() / ofBlocks : 1;
    }

    /// Luminance; none with a single run.
    std::optional<BiasCheck> Bias(const Runs& runs) const {
        if (numRuns_ < 2) return std::nullopt;
        const ColorSpace& space = runs[0]->ColorSpaceOrSRGB();
        double difference = 0, brightness = 0, variance = 0;
        for (const Int2 p : blocks_.pixels) {
            const double r = Luminance(space, reference_.image, p);
            RunningVariance spread;
            for (const Image* run : runs) spread.Add(Luminance(space, *run, p));
            difference += spread.Mean() - r;
            brightness += r;
            variance += spread.VarianceOfMean();
        }
        // Pixels are independent, and so their variances add up; a noise that is only estimated can come out
        // below zero.
        const auto count = double(blocks_.pixels.size());
        variance += std::max(0.0, std::accumulate(luminanceNoise_.begin(), luminanceNoise_.end(), 0.0));
        return BiasCheck{difference / count, std::sqrt(variance) / count,
                         brightness > 0 ? difference / brightness : 0};
    }

    /// From products of errors of different runs, in which noise is zero in the mean but for the reference's.
    double SystematicShare(const Runs& runs, const Means& measured) const {
        if (numRuns_ < 2) return kNotANumber;
        double sum = 0;
        for (const Int2 pixel : blocks_.pixels) {
            const std::array<double, 4> products = MeanProducts(runs, pixel);
            sum += (products[0] + products[1] + products[2]) / 3;
        }
        const double systematic = sum / double(blocks_.pixels.size()) - measured.noise;
        const double all = measured.meanSquare - measured.noise;
        return all > 0 ? std::clamp(systematic / all, 0.0, 1.0) : kNotANumber;
    }

  private:
    static double Luminance(const ColorSpace& space, const Image& image, Int2 p) {
        return double(space.Luminance({image.Get(p, 0), image.Get(p, 1), image.Get(p, 2)}));
    }

    void Add(const Runs& runs) {
        squares_.emplace_back(runs.size(), std::vector<float>(blocks_.pixels.size()));
        relative_.emplace_back(runs.size(), std::vector<float>(blocks_.pixels.size()));
        for (size_t i = 0; i < runs.size(); ++i)
            for (size_t p = 0; p < blocks_.pixels.size(); ++p) {
                squares_.back()[i][p] = SquaredError(*runs[i], reference_.image, blocks_.pixels[p]);
                relative_.back()[i][p] = RelativeSquaredError(*runs[i], reference_.image, blocks_.pixels[p]);
            }
    }

    /// Variance of the reference in each pixel: its own figure, or from products of errors of different runs.
    void ReadNoise(const std::vector<Runs>& runs) {
        noise_.assign(blocks_.pixels.size(), 0.f);
        luminanceNoise_.assign(blocks_.pixels.size(), 0.0);
        if (!reference_.NoiseIsKnown()) {
            EstimateNoise(runs);
            return;
        }
        const int first = reference_.image.FindChannel(NoiseChannels()[0]);
        for (size_t p = 0; p < blocks_.pixels.size(); ++p) {
            const Int2 pixel = blocks_.pixels[p];
            for (int c = 0; c < 3; ++c) noise_[p] += reference_.image.Get(pixel, first + c) / 3;
            luminanceNoise_[p] = double(reference_.image.Get(pixel, first + 3));
        }
    }

    /// From the runs of one estimator at a time, since a bias adds its square; the least of them is taken.
    /// From all runs together where each estimator has one.
    void EstimateNoise(const std::vector<Runs>& runs) {
        std::vector<Runs> groups = runs;
        if (numRuns_ == 1) {
            groups.assign(1, {});
            for (const Runs& ofOne : runs) groups[0].push_back(ofOne[0]);
            if (groups[0].size() == 1) return;
        }
        double least = kInfinity;
        for (const Runs& group : groups) {
            std::vector<float> noise;
            std::vector<double> luminanceNoise;
            double sum = 0;
            for (const Int2 pixel : blocks_.pixels) {
                const std::array<double, 4> products = MeanProducts(group, pixel);
                noise.push_back(float((products[0] + products[1] + products[2]) / 3));
                luminanceNoise.push_back(products[3]);
                sum += double(noise.back());
            }
            if (sum >= least) continue;
            least = sum;
            noise_ = noise;
            luminanceNoise_ = luminanceNoise;
        }
    }

    /// For n independent x_i of one mean, the mean of (x_i - r)(x_j - r) over i != j is (mean - r)^2 in
    /// expectation: R, G, B and luminance.
    std::array<double, 4> MeanProducts(const Runs& runs, Int2 pixel) const {
        const ColorSpace& space = runs[0]->ColorSpaceOrSRGB();
        const double luminance = Luminance(space, reference_.image, pixel);
        double sum[4] = {}, squares[4] = {};
        for (const Image* image : runs) {
            double errors[4] = {0, 0, 0, Luminance(space, *image, pixel) - luminance};
            for (int c = 0; c < 3; ++c)
                errors[c] = double(image->Get(pixel, c)) - double(reference_.image.Get(pixel, c));
            for (int c = 0; c < 4; ++c) {
                sum[c] += errors[c];
                squares[c] += errors[c] * errors[c];
            }
        }
        const auto n = double(runs.size());
        std::array<double, 4> products;
        for (size_t c = 0; c < 4; ++c) products[c] = (sum[c] * sum[c] - squares[c]) / (n * (n - 1));
        return products;
    }

    Means SumsOf(size_t estimator, const float* runWeights, size_t begin, size_t end) const {
        Means sums;
        for (size_t p = begin; p < end; ++p) {
            float square = 0, relative = 0;
            for (size_t i = 0; i < numRuns_; ++i) {
                square += runWeights[i] * squares_[estimator][i][p];
                relative += runWeights[i] * relative_[estimator][i][p];
            }
            sums.rootMeanSquare += double(std::sqrt(square));
            sums.meanSquare += double(square);
            sums.relative += double(relative);
            sums.noise += double(noise_[p]);
        }
        return sums;
    }

    Blocks blocks_;
    const Reference& reference_;
    size_t numRuns_;
    std::vector<std::vector<std::vector<float>>> squares_, relative_;  ///< [estimator][run][pixel]
    std::vector<float> noise_;
    std::vector<double> luminanceNoise_;
};

/// Every block once, with all its runs.
Resampling AllOnce(const BoxErrors& errors) {
    const size_t runs = errors.NumRuns(), blocks = errors.NumBlocks();
    return {std::vector<int>(blocks, 1), std::vector<float>(runs * blocks, 1 / float(runs))};
}

/// Draws with replacement: the runs anew in each block, or, where there is only one, the blocks.
Resampling SampleWithReplacement(const BoxErrors& errors, Rng& rng) {
    Resampling resampling = AllOnce(errors);
    const auto runs = uint32_t(errors.NumRuns()), blocks = uint32_t(errors.NumBlocks());
    if (runs == 1) {
        std::fill(resampling.blocks.begin(), resampling.blocks.end(), 0);
        for (uint32_t i = 0; i < blocks; ++i) ++resampling.blocks[rng.UniformInt(blocks)];
        return resampling;
    }
    std::fill(resampling.runWeights.begin(), resampling.runWeights.end(), 0.f);
    for (uint32_t b = 0; b < blocks; ++b)
        for (uint32_t i = 0; i < runs; ++i)
            resampling.runWeights[b * runs + rng.UniformInt(runs)] += 1 / float(runs);
    return resampling;
}

/// Replicates of all estimators. [estimator][replicate]
std::vector<std::vector<Means>> Bootstrap(const BoxErrors& errors, uint64_t seed) {
    std::vector<std::vector<Means>> replicates(errors.NumEstimators(), std::vector<Means>(kReplicates));
    ParallelFor(kReplicates, [&](int64_t replicate) {
        Rng rng(Hash(seed, replicate));
        const Resampling resampling = SampleWithReplacement(errors, rng);
        for (size_t e = 0; e < replicates.size(); ++e)
            replicates[e][size_t(replicate)] = errors.Resample(e, resampling);
    });
    return replicates;
}

/// Below this mean of a chi-square variable over its degrees of freedom 95 % lie [Wilson and Hilferty 1931].
double LargestByChance(double degrees) {
    constexpr double kQuantile = 1.645;
    const double v = 2 / (9 * degrees);
    const double root = 1 - v + kQuantile * std::sqrt(v);
    return root * root * root;
}

/// For each estimator, by how much its replicates have to be stretched since errors of a whole image go
/// together; see MeasureBox.
std::vector<double> StretchesBySharedErrors(const BoxErrors& errors) {
    const size_t count = errors.NumEstimators();
    std::vector<double> variances;
    for (size_t e = 0; e < count; ++e) variances.push_back(errors.SharedVariance(e));
    const double mean = std::accumulate(variances.begin(), variances.end(), 0.0) / double(count);
    const double degrees = double(count) * double(errors.NumRuns() - 1);
    if (degrees < 1 || errors.NumBlocks() < kMinBlocks || mean <= LargestByChance(degrees))
        return std::vector<double>(count, 1.0);
    const double tails = SidakCritical(1 - kConfidence, 1, degrees) / SidakCritical(1 - kConfidence, 1);
    for (double& v : variances) v = tails * std::sqrt(std::max(mean, v));
    return variances;
}

/// Interval around `value` from replicates of it; see MeasureBox.
Interval IntervalOf(double value, const std::vector<double>& replicates) {
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
    return {value, value * std::exp(quantile(tail)), value * std::exp(quantile(1 - tail))};
}

/// Takes replicates `factor` times as far from the mean of their logarithms; NaN where that is.
void Stretch(double factor, std::vector<Means>* replicates) {
    if (factor == 1) return;
    for (double Means::*member : {&Means::rootMeanSquare, &Means::meanSquare, &Means::relative}) {
        RunningVariance logs;
        for (const Means& m : *replicates)
            if (m.*member > 0) logs.Add(std::log(m.*member));
        for (Means& m : *replicates)
            if (m.*member > 0)
                m.*member = std::exp(logs.Mean() + factor * (std::log(m.*member) - logs.Mean()));
    }
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

/// From here on, two errors are called indistinguishable.
constexpr double kSameLevel = 0.05;

/// Errors of all estimators at equal time, measured and in the replicates of a bootstrap.
class Comparison {
  public:
    Comparison(const std::vector<Means>& measured, const std::vector<std::vector<Means>>& replicates,
               const std::vector<double>& seconds) {
        for (size_t e = 0; e < measured.size(); ++e) {
            const double scale = seconds.empty() ? 1 : std::sqrt(seconds[e] / seconds[0]);
            measured_.push_back(scale * measured[e].Corrected());
            replicates_.push_back(Each([&](size_t i) { return scale * replicates[e][i].Corrected(); }));
        }
    }

    /// The error of `a` over that of `b`.
    Interval RatioOf(size_t a, size_t b) const {
        return IntervalOf(Ratio(measured_[a], measured_[b]), RatiosOf(a, b));
    }

    /// Fills in how each stands to the best. One that is untested, since most of its error is the reference's
    /// noise, may well have the least: then nobody is called best, and only losers are told.
    void Judge(std::vector<BoxResult>* results) const {
        size_t best = 0;
        for (size_t e = 1; e < measured_.size(); ++e)
            if (measured_[e] < measured_[best] || std::isnan(measured_[best])) best = e;
        const size_t numPairs = measured_.size() * (measured_.size() - 1) / 2;
        for (size_t e = 0; e < measured_.size(); ++e) {
            BoxResult& r = (*results)[e];
            r.rmseOverBest = RatioOf(e, best);
            r.verdict = std::isnan(measured_[e]) ? Verdict::Untested : Verdict::Best;
            if (e == best) continue;
            r.pEqual = SidakP(TwoSidedNormalP(Sigmas(e, best)), numPairs);
            r.verdict = std::isnan(r.pEqual)    ? Verdict::Untested
                        : r.pEqual < kSameLevel ? Verdict::Worse
                                                : Verdict::Indistinguishable;
        }
        if (std::none_of(measured_.begin(), measured_.end(), [](double x) { return std::isnan(x); })) return;
        for (BoxResult& r : *results)
            if (r.verdict != Verdict::Worse) r.verdict = Verdict::Untested;
    }

  private:
    std::vector<double> RatiosOf(size_t a, size_t b) const {
        return Each([&](size_t i) { return Ratio(replicates_[a][i], replicates_[b][i]); });
    }

    /// The difference of the logarithms in standard errors; NaN if there is none.
    double Sigmas(size_t a, size_t b) const {
        RunningVariance logs;
        for (const double ratio : RatiosOf(a, b))
            if (ratio > 0 && std::isfinite(ratio)) logs.Add(std::log(ratio));
        if (logs.Count() < kReplicates / 2) return kNotANumber;
        return std::log(Ratio(measured_[a], measured_[b])) / std::sqrt(logs.Variance());
    }

    std::vector<double> measured_;
    std::vector<std::vector<double>> replicates_;
};

}  // namespace

std::vector<BoxResult> MeasureBox(const Bounds2i& pixels, const Reference& reference,
                                  const std::vector<Runs>& runs, size_t baseline, uint64_t seed,
                                  const std::vector<double>& seconds) {
    const BoxErrors errors(pixels, reference, runs);
    std::vector<std::vector<Means>> replicates = Bootstrap(errors, seed);
    std::vector<Means> measured;
    for (size_t e = 0; e < runs.size(); ++e) measured.push_back(errors.Resample(e, AllOnce(errors)));

    const auto n = double(errors.NumRuns());
    // One run of one block shows no spread at all.
    const double stretch = n > 1 ? std::sqrt(n / (n - 1)) : errors.NumBlocks() > 1 ? 1 : kNotANumber;
    const std::vector<double> shared = StretchesBySharedErrors(errors);
    for (size_t e = 0; e < runs.size(); ++e) Stretch(stretch * shared[e], &replicates[e]);
    const Comparison comparison(measured, replicates, seconds);
    std::vector<BoxResult> results;
    for (size_t e = 0; e < runs.size(); ++e) {
        const std::vector<Means>& ofOne = replicates[e];
        BoxResult r;
        r.rmse =
            IntervalOf(measured[e].rootMeanSquare, Each([&](size_t i) { return ofOne[i].rootMeanSquare; }));
        r.relativeMse = IntervalOf(measured[e].relative, Each([&](size_t i) { return ofOne[i].relative; }));
        r.sharedErrors = shared[e];
        r.rmseCorrected = measured[e].Corrected();
        r.referenceNoise = measured[e].noise;
        r.referenceNoiseShare = measured[e].NoiseShare();
        r.bias = errors.Bias(runs[e]);
        r.systematicShare = errors.SystematicShare(runs[e], measured[e]);
        r.rmseReduction = comparison.RatioOf(baseline, e);
        r.timeReduction = Squared(r.rmseReduction);
        results.push_back(r);
    }
    comparison.Judge(&results);
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
    std::vector<float> errors;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x)
            errors.push_back(SquaredError(image, reference, {x, y}));
    return errors;
}

}  // namespace lacquer::compare
