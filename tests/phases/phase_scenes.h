// Scenes with one medium or one slab, and radiance at the wavelengths of a path.
#pragma once

#include <fmt/format.h>

#include "integrators/render_fixtures.h"
#include "phases/phase_checks.h"

namespace lacquer::test {

/// A camera that looks at the origin from `eye`.
inline std::string View(const std::string& integrator, int maxDepth, Vec3 eye) {
    return fmt::format(
        "LookAt {} {} {}  0 0 0  0.1 1 0.2 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 "
        "\"integer yresolution\" 4 Sampler \"independent\" Integrator \"{}\" \"integer maxdepth\" {} "
        "WorldBegin ",
        eye.x, eye.y, eye.z, integrator, maxDepth);
}

inline const std::string kWhite = "LightSource \"infinite\" \"rgb L\" [1 1 1] ";
inline const std::string kBall = "MediumInterface \"m\" \"\" Material \"interface\" Shape \"sphere\" ";

/// Radiance through the middle of the image at 450, 550, 650 and 750 nm, each in turn the first one.
inline std::array<RunningMean, kNumTested> SpectralRadiance(const std::string& scene, int samples,
                                                            uint64_t seed) {
    const RenderSetup setup = BuildText(scene);
    std::array<RunningMean, kNumTested> means;
    ThreadState state;
    const auto sampler = setup.sampler->Clone();
    for (int i = 0; i < samples; ++i) {
        sampler->StartPixelSample({int(seed % 1009), int(seed / 1009 % 1009)}, i);
        state.rng = Rng(Hash(seed, i));
        SampledWavelengths lambda = Four(i % kNumTested);
        const auto ray =
            setup.scene->Camera().GenerateRay({Point2(setup.scene->Resolution()) / 2.f, Point2(0.5f), 0.5f});
        const SampledSpectrum L = setup.integrator->Li(*ray, lambda, *sampler, state);
        for (int l = 0; l < kNumTested; ++l) means[size_t((i + l) % kNumTested)].Add(double(L[l]));
        state.arena.Reset();
    }
    return means;
}

/// The worst wavelength of a ball of a medium that does not absorb, in white surroundings. Standard errors
/// are below 0.2 %.
inline Outcome FurnaceAtEachWavelength(const std::string& medium, uint64_t seed) {
    const int samples = Scaled(640000);
    const auto empty = SpectralRadiance(View("volpath", 5, {3, 1, -2}) + kWhite, 4, 1);
    const auto all =
        SpectralRadiance(View("volpath", 4000, {3, 1, -2}) + kWhite + medium + kBall, samples, seed);
    std::vector<Outcome> outcomes;
    for (size_t l = 0; l < all.size(); ++l) {
        EXPECT_LT(all[l].StandardError(), 1.6 / std::sqrt(samples) * empty[l].Mean());
        outcomes.push_back(ZTest(all[l], empty[l].Mean(), 1e-5 * empty[l].Mean(), "furnace"));
    }
    return WorstOf(outcomes);
}

/// Radiance of 3 from a direction.
inline std::string Distant(Vec3 from) {
    return fmt::format(
        "LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [{} {} {}] \"point3 to\" [0 0 0] ", from.x,
        from.y, from.z);
}

/// Whether the two have the same luminance.
inline Outcome Compare(const std::string& a, const std::string& b, int samples, uint64_t seed) {
    const RunningMean x = CenterRadiance(BuildText(a), samples, seed);
    const RunningMean y = CenterRadiance(BuildText(b), samples, seed + 1);
    const double error = std::hypot(x.StandardError(), y.StandardError());
    return {NormalTwoSided((x.Mean() - y.Mean()) / error),
            fmt::format("{} and {} +- {}", x.Mean(), y.Mean(), error)};
}

}  // namespace lacquer::test
