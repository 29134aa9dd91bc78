#include "sampler_bench.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "cpu_time.h"
#include "pbrt/core/rng.h"
#include "slope_samplers.h"

namespace lacquer::bench {
namespace {

/// Moments of the slopes of visible facets in units of alpha: x along the view, y across it.
struct Moments {
    static constexpr int kCount = 4;
    std::array<double, kCount> values{};  ///< E[x], E[x^2], E[x^3], E[y^2]

    static std::array<double, kCount> Of(double x, double y) { return {x, x * x, x * x * x, y * y}; }
};

/// By quadrature of the density (cos - x sin)+ exp(-x^2) for the stretched view; y is Gaussian. The
/// trapezoidal rule on a smooth function that vanishes at both ends, but for a kink: error below 1e-6.
Moments ExpectedMoments(double sinTheta, double cosTheta) {
    constexpr int kSteps = 200000;
    constexpr double kExtent = 7;
    double norm = 0;
    Moments moments;
    for (int i = 0; i <= kSteps; ++i) {
        const double x = kExtent * (2. * i / kSteps - 1);
        const double weight = std::max(0., cosTheta - x * sinTheta) * std::exp(-x * x);
        norm += weight;
        const auto powers = Moments::Of(x, 0);
        for (size_t k = 0; k < Moments::kCount; ++k) moments.values[k] += weight * powers[k];
    }
    for (double& value : moments.values) value /= norm;
    moments.values[3] = 0.5;
    return moments;
}

struct View {
    float alpha, angleDeg;
    Vec3 W() const { return {std::sin(Radians(angleDeg)), 0, std::cos(Radians(angleDeg))}; }
    Moments Expected() const {
        const double s = double(alpha) * double(W().x), c = double(W().z), length = std::hypot(s, c);
        return ExpectedMoments(s / length, c / length);
    }
};

/// The largest deviation of a moment [standard errors].
double WorstDeviation(SlopeSampler sampler, const View& view, int numSamples) {
    const Beckmann facets(view.alpha, view.alpha);
    Rng rng(Hash(view.alpha, view.angleDeg, int(sampler)));
    Moments sum, squares;
    const Vec3 w = view.W();
    for (int i = 0; i < numSamples; ++i) {
        const Vec3 wm = SampleVisible(sampler, facets, w, rng.Uniform2D());
        const double scale = -1 / (double(wm.z) * double(view.alpha));
        const auto powers = Moments::Of(double(wm.x) * scale, double(wm.y) * scale);
        for (size_t k = 0; k < Moments::kCount; ++k) {
            sum.values[k] += powers[k];
            squares.values[k] += powers[k] * powers[k];
        }
    }
    const Moments expected = view.Expected();
    double worst = 0;
    for (size_t k = 0; k < Moments::kCount; ++k) {
        const double mean = sum.values[k] / numSamples;
        const double variance = squares.values[k] / numSamples - mean * mean;
        worst = std::max(worst, std::abs(mean - expected.values[k]) / std::sqrt(variance / numSamples));
    }
    return worst;
}

/// Nanoseconds of one draw by each sampler; they take turns.
std::vector<double> Nanoseconds(const View& view, double seconds) {
    constexpr int kBatch = 4096;
    const auto samplers = SlopeSamplers();
    const Beckmann facets(view.alpha, view.alpha);
    const Vec3 w = view.W();
    std::vector<double> used(samplers.size());
    Vec3 sum(0);
    int rounds = 0;
    for (double total = 0; total < seconds * double(samplers.size()); ++rounds)
        for (size_t i = 0; i < samplers.size(); ++i) {
            Rng rng(Hash(rounds));
            const double start = CpuSeconds();
            for (int k = 0; k < kBatch; ++k)
                sum += SampleVisible(samplers[i].sampler, facets, w, rng.Uniform2D());
            const double taken = CpuSeconds() - start;
            used[i] += taken;
            total += taken;
        }
    for (double& ns : used) ns *= 1e9 / (double(rounds) * kBatch);
    // Keeps the draws from being optimised away.
    if (sum.z < 0) fmt::print("impossible\n");
    return used;
}

}  // namespace

bool RunSamplerBench(double seconds) {
    constexpr int kSamples = 400000;
    constexpr double kLimit = 5;
    fmt::print(
        "Drawing one visible Beckmann normal: ns, and (largest deviation of a moment of the slopes in"
        " standard errors).\n{:>6} {:>6}",
        "alpha", "angle");
    for (const NamedSlopeSampler& s : SlopeSamplers())
        if (s.sampler != SlopeSampler::Control) fmt::print(" {:>16}", s.name);
    fmt::print("\n");
    bool isRight = true;
    for (const float alpha : {0.05f, 0.1f, 0.3f, 0.5f, 1.f})
        for (const float angle : {0.f, 30.f, 60.f, 80.f, 88.f}) {
            const View view{alpha, angle};
            const std::vector<double> ns = Nanoseconds(view, seconds);
            fmt::print("{:>6g} {:>6g}", alpha, angle);
            for (size_t i = 0; i < ns.size(); ++i) {
                if (SlopeSamplers()[i].sampler == SlopeSampler::Control) continue;
                const double deviation = WorstDeviation(SlopeSamplers()[i].sampler, view, kSamples);
                isRight &= deviation < kLimit;
                fmt::print(" {:>9.1f} {:>6}", ns[i], fmt::format("({:.1f})", deviation));
            }
            fmt::print("\n");
            std::fflush(stdout);
        }
    fmt::print("{}\n", isRight ? "All moments agree." : "A MOMENT IS OFF.");
    return isRight;
}

}  // namespace lacquer::bench
