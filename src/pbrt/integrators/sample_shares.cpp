#include "pbrt/integrators/sample_shares.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "pbrt/core/check.h"
#include "pbrt/core/math.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/scattered_order.h"
#include "pbrt/integrators/noise_level.h"
#include "pbrt/integrators/window_sums.h"

namespace lacquer {
namespace {

/// Sides of the windows over which errors are averaged, and of those for values and costs [pilots].
constexpr int kWindows[] = {4, 8, 16, 32};
constexpr int kScaleWindow = 8, kCostWindow = 16;
/// If the squared error of n samples is v / n^a, v^(1 / (1 + a)) of them are best: a is 1 for independent
/// samples and up to 3 for well distributed ones where the image is smooth. The first is for a = 1.5, as of
/// edges; the second is for noise of which the pilots tell little.
constexpr double kExponents[] = {0.4, 0.2};
/// Shares must promise this much more than even samples do.
constexpr double kMinGain = 1.05;
/// No pilot tells more than that [squared error in units of value^2 + e^2].
constexpr double kMaxError = 1024;

float LargestOf(const RGB& value) { return MaxComponent(glm::abs(value)); }

/// A value far above those of all but a thousandth of the pilots: with larger ones the image's mean would be
/// that of a few pilots, beside which all others are black.
float MaxValue(const std::vector<PilotPixel>& pilots) {
    constexpr double kTimes = 1024;
    std::vector<float> values;
    values.reserve(pilots.size());
    for (const PilotPixel& pilot : pilots) values.push_back(LargestOf(pilot.mean));
    const size_t leftOut = std::max<size_t>(1, values.size() / 1000);
    const size_t count = std::max<size_t>(1, values.size() - leftOut);
    std::nth_element(values.begin(), values.begin() + ptrdiff_t(count - 1), values.end());
    const double sum = std::accumulate(values.begin(), values.begin() + ptrdiff_t(count), 0.0);
    return sum > 0 ? float(std::min(kTimes * sum / double(count), 1e30)) : std::numeric_limits<float>::max();
}

/// The squared relative error of one estimate of each pixel, by the two that there are.
std::vector<double> SquaredErrors(Int2 size, const std::vector<PilotPixel>& pilots) {
    const float most = MaxValue(pilots);
    const auto scaleOf = [&](const PilotPixel& pilot) {
        return most / std::max(most, LargestOf(pilot.mean));
    };
    std::vector<RGB> means;
    means.reserve(pilots.size());
    for (const PilotPixel& pilot : pilots) means.push_back(pilot.mean * scaleOf(pilot));
    std::vector<double> errors = SquaredScales(size, means, kScaleWindow);
    for (size_t i = 0; i < pilots.size(); ++i) {
        const RGB d = pilots[i].difference * scaleOf(pilots[i]);
        errors[i] = std::min(double(glm::dot(d, d)) / (6 * errors[i]), kMaxError);
    }
    return errors;
}

/// The pilots of windows: all, or all but the pixel's own.
enum class Of { All, Others };

/// Geometric means, over windows of all sizes around a pixel, of the means of values in them. Few pilots
/// leave the small windows noisy, and the large ones blur what is small: the product follows an edge, with
/// less noise than the small windows have. A window tells a quarter of what the next larger one does at
/// least: where noise is rare, most small windows have seen none, and nothing times anything is nothing.
std::vector<double> MeansOfAllSizes(Int2 size, const std::vector<double>& values, Of whose) {
    constexpr float kMinRatio = 0.25f;
    constexpr double kLeast = 1e-12;  // so that black has a logarithm
    WindowSums sums(size);
    ForAllPixels(size, [&](Int2 p, size_t i) { sums.Set(p, values[i]); });
    std::array<std::vector<float>, std::size(kWindows)> means;
    for (size_t k = 0; k < means.size(); ++k) {
        sums.GrowTo(kWindows[k]);
        means[k].resize(values.size());
        ForAllPixels(size, [&](Int2 p, size_t i) {
            means[k][i] = float(whose == Of::All ? sums.Mean(p) : sums.MeanOfOthers(p, values[i]));
        });
    }
    std::vector<double> products(values.size());
    for (size_t i = 0; i < values.size(); ++i) {
        float least = 0;
        double logs = 0;
        for (size_t k = means.size(); k-- > 0; least *= kMinRatio) {
            least = std::max(least, means[k][i]);
            logs += std::log(double(least) + kLeast);
        }
        products[i] = std::exp(logs / double(means.size()));
    }
    return products;
}

std::vector<double> MeanCosts(Int2 size, const std::vector<PilotPixel>& pilots) {
    WindowSums costs(size);
    ForAllPixels(size, [&](Int2 p, size_t i) { costs.Set(p, double(pilots[i].cost)); });
    costs.GrowTo(kCostWindow);
    std::vector<double> means(pilots.size());
    ForAllPixels(size, [&](Int2 p, size_t i) { means[i] = costs.Mean(p); });
    return means;
}

/// What pilots tell of the blocks that they are in.
class PilotAnalysis {
  public:
    PilotAnalysis(Int2 blocks, const std::vector<PilotPixel>& pilots)
        : blocks_(blocks),
          pilots_(pilots),
          errors_(SquaredErrors(blocks, pilots)),
          meanCosts_(MeanCosts(blocks, pilots)) {}
    /// Empty: even samples are as good.
    std::optional<double> BestExponent() const {
        const std::vector<double> others = MeansOfAllSizes(blocks_, errors_, Of::Others);
        std::optional<double> best;
        double most = kMinGain;
        for (const double exponent : kExponents)
            if (const double gain = Gain(Density(others, exponent)); gain > most) {
                most = gain;
                best = exponent;
            }
        return best;
    }
    std::vector<double> DensityOfPixels(const Bounds2i& pixels, int spacing, double exponent) const {
        const std::vector<double> ofBlocks = Density(MeansOfAllSizes(blocks_, errors_, Of::All), exponent);
        std::vector<double> density(size_t(pixels.Area()));
        ForAllPixels({pixels.Width(), pixels.Height()}, [&](Int2 p, size_t i) {
            const Int2 block = p / spacing;
            density[i] = ofBlocks[size_t(block.y) * size_t(blocks_.x) + size_t(block.x)];
        });
        return density;
    }

  private:
    std::vector<double> Density(const std::vector<double>& errors, double exponent) const {
        std::vector<double> density(errors.size());
        for (size_t i = 0; i < density.size(); ++i)
            density[i] = std::pow(errors[i] / std::max(meanCosts_[i], 1.0), exponent);
        return density;
    }
    /// Of 1 / (error x time) over that of even samples, if each sample takes as much off the error as an
    /// independent one. Shares that follow a pixel's own pilots would look better than they are.
    /// @param density  of shares that know nothing of the pixel's own pilots
    double Gain(const std::vector<double>& density) const {
        const SampleShares shares = SharesInProportion({Int2(0), blocks_}, density);
        double even = 0, evenTime = 0, error = 0, time = 0;
        for (size_t i = 0; i < density.size(); ++i) {
            const double share = double(shares.Shares()[i]) / SampleShares::kUnit;
            even += errors_[i];
            error += errors_[i] / share;
            evenTime += double(pilots_[i].cost);
            time += double(pilots_[i].cost) * share;
        }
        return error * time > 0 ? even * evenTime / (error * time) : 0;
    }

    Int2 blocks_;
    const std::vector<PilotPixel>& pilots_;
    std::vector<double> errors_, meanCosts_;
};

uint8_t Share(double density) {
    return uint8_t(std::lround(std::clamp(density * SampleShares::kUnit, 1.0, double(SampleShares::kMax))));
}

/// Shares that have just not reached the next step reach it, as many as there are samples for, spread over
/// the image: all pixels of an even part have one density, and step together.
/// @param factor  by which they do
void GiveRest(const std::vector<double>& density, double factor, int64_t rest, std::vector<uint8_t>* shares) {
    const auto count = int64_t(density.size()), stride = ScatteringStride(count);
    for (int64_t k = 0; k < count && rest > 0; ++k) {
        const auto i = size_t(k * stride % count);
        const int step = int(Share(density[i] * factor)) - int((*shares)[i]);
        if (step <= 0 || step > rest) continue;
        (*shares)[i] = uint8_t((*shares)[i] + step);
        rest -= step;
    }
}

}  // namespace

SampleShares::SampleShares(const Bounds2i& pixels, std::vector<uint8_t> shares)
    : pixels_(pixels), shares_(std::move(shares)) {
    LACQUER_CHECK(shares_.size() == size_t(pixels.Area()));
}

int64_t SampleShares::FewestOf(int first, int end) const {
    int64_t fewest = std::numeric_limits<int64_t>::max();
    for (const uint8_t share : shares_)
        fewest = std::min(fewest, SamplesOfShare(share, end) - SamplesOfShare(share, first));
    return fewest;
}

bool SampleShares::AreEven() const {
    return std::all_of(shares_.begin(), shares_.end(), [&](uint8_t share) { return share == shares_[0]; });
}

uint64_t SampleShares::Fingerprint() const {
    uint64_t hash = Hash(pixels_.min.x, pixels_.min.y, pixels_.max.x, pixels_.max.y);
    for (const uint8_t share : shares_) hash = Hash(hash, share);
    return hash;
}

SampleShares SharesInProportion(const Bounds2i& pixels, const std::vector<double>& density) {
    const auto total = [&](double factor) {
        constexpr size_t kRun = 1 << 16;
        std::atomic<int64_t> sum = 0;
        ParallelFor(int64_t((density.size() + kRun - 1) / kRun), [&](int64_t run) {
            const size_t begin = size_t(run) * kRun, end = std::min(begin + kRun, density.size());
            int64_t ofRun = 0;
            for (size_t i = begin; i < end; ++i) ofRun += Share(density[i] * factor);
            sum += ofRun;
        });
        return sum.load();
    };
    // Limits take from the mean or add to it: the factor that makes up for that is found by bisection.
    const int64_t wanted = int64_t(density.size()) * SampleShares::kUnit;
    double sum = 0;
    for (const double d : density) sum += d;
    double low = 0, high = sum > 0 ? double(density.size()) / sum : 1;
    for (int i = 0; i < 60 && total(high) < wanted; ++i) high *= 2;
    for (int i = 0; i < 40; ++i) (total((low + high) / 2) <= wanted ? low : high) = (low + high) / 2;
    std::vector<uint8_t> shares;
    shares.reserve(density.size());
    for (const double d : density) shares.push_back(Share(d * low));
    GiveRest(density, high, wanted - total(low), &shares);
    return {pixels, std::move(shares)};
}

SampleShares SharesByPilots(const Bounds2i& pixels, int spacing, const std::vector<PilotPixel>& pilots) {
    const Int2 blocks = PilotBlocksOf(pixels, spacing);
    LACQUER_CHECK(pilots.size() == size_t(blocks.x) * size_t(blocks.y));
    const PilotAnalysis analysis(blocks, pilots);
    const std::optional<double> exponent = analysis.BestExponent();
    if (!exponent) return {pixels, std::vector<uint8_t>(size_t(pixels.Area()), SampleShares::kUnit)};
    return SharesInProportion(pixels, analysis.DensityOfPixels(pixels, spacing, *exponent));
}

}  // namespace lacquer
