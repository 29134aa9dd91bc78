#include "pbrt/integrators/sample_shares.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pbrt/core/check.h"
#include "pbrt/core/math.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/scattered_order.h"
#include "pbrt/integrators/noise_level.h"
#include "pbrt/integrators/window_sums.h"

namespace lacquer {
namespace {

/// Side of the smallest and of the largest window [pixels].
constexpr int kFirstWindow = 4, kLastWindow = WindowSums::kLargest;
/// Side of the window for what samples cost.
constexpr int kCostWindow = 16;
/// If the squared error of n samples is v / n^a, v^(1 / (1 + a)) of them are best: a is 1 for independent
/// samples and up to 3 for well distributed ones where the image is smooth. This is for a = 1.5, as of edges.
constexpr double kExponent = 0.4;
/// A difference of so many standard deviations is real.
constexpr double kSignificance = 2;

/// The squared relative error of one estimate of each pixel, by the two that there are.
std::vector<double> SquaredErrors(Int2 size, const std::vector<PilotPixel>& pilots) {
    std::vector<RGB> means;
    means.reserve(pilots.size());
    for (const PilotPixel& pilot : pilots) means.push_back(pilot.mean);
    std::vector<double> errors = SquaredScales(size, means);
    for (size_t i = 0; i < pilots.size(); ++i) {
        const RGB d = pilots[i].difference;
        // Limited to what squares can be summed of.
        errors[i] = std::min(double(glm::dot(d, d)) / (6 * errors[i]), 1e12);
    }
    return errors;
}

/// A mean of `count` values as it was known before, judged by a mean of more values around it.
struct LocalMean {
    double value = 0, count = 0;
    void Refine(double wider, double widerVariance, double widerCount) {
        const double difference = value - wider;
        // If all values were of one distribution, the mean of `count` of them would vary by this.
        const double chance = Sqr(kSignificance) * widerVariance / std::max(count, 1.0);
        const double real = Sqr(difference) > chance ? 1 - Sqr(chance / Sqr(difference)) : 0;
        value = wider + real * difference;
        count = widerCount + real * (count - widerCount);
    }
};

std::vector<LocalMean> LocalMeans(Int2 size, const std::vector<double>& values) {
    WindowSums sums(size), squares(size);
    ForAllPixels(size, [&](Int2 p, size_t i) {
        sums.Set(p, values[i]);
        squares.Set(p, Sqr(values[i]));
    });
    std::vector<LocalMean> means(values.size());
    for (int window = kFirstWindow; window <= kLastWindow; window *= 2) {
        sums.GrowTo(window);
        squares.GrowTo(window);
        ForAllPixels(size, [&](Int2 p, size_t i) {
            const double mean = sums.Mean(p), count = sums.Count(p);
            if (window == kFirstWindow)
                means[i] = {mean, count};
            else
                means[i].Refine(mean, std::max(0.0, squares.Mean(p) - Sqr(mean)), count);
        });
    }
    double mean = 0, square = 0;
    for (const double value : values) {
        mean += value / double(values.size());
        square += Sqr(value) / double(values.size());
    }
    for (LocalMean& local : means)
        local.Refine(mean, std::max(0.0, square - Sqr(mean)), double(values.size()));
    return means;
}

std::vector<double> MeanRays(Int2 size, const std::vector<PilotPixel>& pilots) {
    WindowSums rays(size);
    ForAllPixels(size, [&](Int2 p, size_t i) { rays.Set(p, double(pilots[i].rays)); });
    rays.GrowTo(kCostWindow);
    std::vector<double> means(pilots.size());
    ForAllPixels(size, [&](Int2 p, size_t i) { means[i] = rays.Mean(p); });
    return means;
}

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

uint64_t SampleShares::Fingerprint() const {
    uint64_t hash = Hash(pixels_.min.x, pixels_.min.y, pixels_.max.x, pixels_.max.y);
    for (const uint8_t share : shares_) hash = Hash(hash, share);
    return hash;
}

SampleShares SharesInProportion(const Bounds2i& pixels, const std::vector<double>& density) {
    const auto total = [&](double factor) {
        int64_t sum = 0;
        for (const double d : density) sum += Share(d * factor);
        return sum;
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
    // Errors have long tails, in which a difference between windows would be lost. Their square roots have
    // not.
    std::vector<double> roots = SquaredErrors(blocks, pilots);
    for (double& root : roots) root = std::sqrt(std::sqrt(root));
    const std::vector<LocalMean> means = LocalMeans(blocks, roots);
    const std::vector<double> rays = MeanRays(blocks, pilots);
    std::vector<double> density(size_t(pixels.Area()));
    ForAllPixels({pixels.Width(), pixels.Height()}, [&](Int2 p, size_t i) {
        const Int2 block = p / spacing;
        const size_t k = size_t(block.y) * size_t(blocks.x) + size_t(block.x);
        density[i] = std::pow(Sqr(Sqr(means[k].value)) / std::max(rays[k], 1.0), kExponent);
    });
    // Without any noise all pixels are alike.
    if (std::all_of(density.begin(), density.end(), [](double d) { return d <= 0; }))
        std::fill(density.begin(), density.end(), 1.0);
    return SharesInProportion(pixels, density);
}

}  // namespace lacquer
