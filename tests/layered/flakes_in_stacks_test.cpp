// Sheets of flakes in stacks: what their samples add up to whatever the window that flakes are counted in.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "layered/stack_cases.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/flakes.h"
#include "pbrt/core/sampling.h"

namespace lacquer::layered::test {
namespace {

constexpr float kRoughness = 0.15f;
constexpr double kAreas = 0.7, kAreaOfFlake = kAreas / FlakeField::kMeanPerTile;
const float kCoverage = float(1 - std::exp(-kAreas));

enum class Passage { Sheet, Window };

/// A window of a mean number of flakes, or of one flake's area.
FlakesInWindow WindowOf(double meanFlakes, Passage passage, Rng& rng) {
    const double area = std::max(meanFlakes / FlakeField::kMeanPerTile, kAreaOfFlake);
    const auto radius = float(std::sqrt(area / std::numbers::pi));
    const double x = double(rng.Uniform()) * 4096, y = double(rng.Uniform()) * 4096;
    FlakesInWindow flakes{FlakeField(21), FlakeWindow(x, y, {radius, 0}, {0, radius}),
                          float(kAreaOfFlake / area), kCoverage};
    if (passage == Passage::Window) flakes.sheetCoverage.reset();
    return flakes;
}

struct Mean {
    double value, error;
};
/// The share of light from 40 degrees that flakes over a base of 0.9 send back. `makeFlakes` makes a sheet.
template <class MakeFlakes>
Mean AlbedoOver(int numWindows, const MakeFlakes& makeFlakes) {
    Rng rng(Hash(numWindows));
    double sum = 0, squares = 0;
    for (int i = 0; i < numWindows; ++i) {
        Arena arena;
        StackBuilder stack(arena);
        stack.AddInterface(makeFlakes(arena, rng));
        stack.AddInterface(arena.New<DiffuseBxDF>(SampledSpectrum(0.9f)));
        LayeredOptions options;
        options.estimator = FindEstimator("bidirectional");
        options.pdf = FindPdf("approximate");
        const LayeredBxDF* bxdf = stack.BuildBxDF(options);
        const Vec3 wo = Normalize(Vec3(0.64f, 0.1f, 0.76f)), wi = SampleCosineHemisphere(rng.Uniform2D());
        const double value =
            double(bxdf->Evaluate(wo, wi, {.rng = &rng, .needsPdf = false}).f[0]) * std::numbers::pi;
        sum += value;
        squares += value * value;
    }
    const double mean = sum / numWindows;
    return {mean, std::sqrt(std::max(squares / numWindows - mean * mean, 0.) / numWindows)};
}
Mean AlbedoInWindows(double flakes, const FlakeOptics& optics, Passage passage) {
    // Windows of a flake differ most and cost least.
    return AlbedoOver(flakes == 0 ? 40000 : 20000, [&](Arena& arena, Rng& rng) -> BxDF* {
        return arena.New<FlakesBxDF<Beckmann>>(Alphas(0.3f, 0.3f), kRoughness, optics,
                                               WindowOf(flakes, passage, rng));
    });
}

// Light goes down through gaps and comes back through others. Of black flakes over a white base that is all
// there is. The means are known to 2 %, of single flakes to 3 %; shares of the window's own gaps (the
// negative control) are half as bright again in windows of a flake.
TEST(FlakesInStacks, MeansDoNotDependOnTheWindow) {
    Mean blackFlake;
    const FlakeOptics black = FlakeOptics::Metal(SampledSpectrum(1), SampledSpectrum(0), {}, 0);
    const FlakeOptics mirror = FlakeOptics::Metal(SampledSpectrum(0), SampledSpectrum(1), {}, 0);
    for (const FlakeOptics* kind : {&black, &mirror}) {
        const FlakeOptics& optics = *kind;
        const Mean endless = AlbedoOver(50000, [&](Arena& arena, Rng&) -> BxDF* {
            return arena.New<FlakesBxDF<Beckmann>>(Alphas(0.3f, 0.3f), kRoughness, optics, kCoverage);
        });
        for (const double flakes : {0., 8., 100.}) {
            const Mean mean = AlbedoInWindows(flakes, optics, Passage::Sheet);
            const double error = std::hypot(mean.error, endless.error);
            EXPECT_NEAR(mean.value, endless.value, 4 * error + 0.01 * endless.value)
                << flakes << " +- " << error << ", reflectance " << optics.MeanReflectance(1)[0];
            EXPECT_LT(error, (flakes == 0 ? 0.03 : 0.02) * endless.value) << flakes;
            if (flakes == 0 && kind == &black) blackFlake = mean;
        }
    }
    const Mean window = AlbedoInWindows(0, black, Passage::Window);
    EXPECT_GT(window.value, 1.3 * blackFlake.value) << "the negative control";
}

}  // namespace
}  // namespace lacquer::layered::test
