// Light through media on grids: transmittance, emission, energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "media/medium_fixtures.h"
#include "pbrt/integrators/medium_tracking.h"
#include "pbrt/media/voxel_grid.h"
#include "pbrt/phases/isotropic.h"

namespace lacquer::test::media_test {
namespace {

constexpr double kAlpha = 1e-5;  // some twenty checks in this file

const std::string kGrid =
    "\"integer nx\" 3 \"integer ny\" 2 \"integer nz\" 3 \"float density\" "
    "[0 3 1 4 0.5 1  1 0 2 3 0 5  0 2 4 1 1 0.2] ";
struct Named {
    const char* type;
    std::string text;
};
const std::vector<Named> kMedia = {
    {"uniformgrid", kGrid + "\"rgb sigma_a\" [0.5 0.5 0.5] \"rgb sigma_s\" [1 1.5 0.3]"},
    {"rgbgrid", "\"integer nx\" 2 \"integer nz\" 2 \"rgb sigma_a\" [4 1 2  0.3 2 1  0 0 0  5 4 3]"},
    {"cloud", "\"float density\" 2 \"rgb sigma_a\" [1 1 2] \"rgb sigma_s\" [1 3 1]"},
};

const Ray kRay{{-0.3f, 0.3f, -0.2f}, Normalize(Vec3(1, 0.3f, 0.9f))};
constexpr float kLength = 2;

/// exp(- integral of sigma_t along kRay) for each wavelength, by the midpoint rule.
std::array<double, kNumWavelengths> MarchedTransmittance(const Medium& medium,
                                                         const SampledWavelengths& lambda) {
    constexpr int kSteps = 20000;
    std::array<double, kNumWavelengths> depth{};
    for (int i = 0; i < kSteps; ++i) {
        const SampledSpectrum sigma = medium.At(kRay((float(i) + 0.5f) * kLength / kSteps), lambda).SigmaT();
        for (int l = 0; l < kNumWavelengths; ++l)
            depth[size_t(l)] += double(sigma[l]) * double(kLength) / kSteps;
    }
    for (double& d : depth) d = std::exp(-d);
    return depth;
}

/// Ratio tracking of the transmittance along kRay, as TrackCollisions gives its collisions.
Outcome TrackedTransmittance(const Medium& medium, int samples, uint64_t seed) {
    const SampledWavelengths lambda = SomeWavelengths();
    const auto expected = MarchedTransmittance(medium, lambda);
    RunningMean means[kNumWavelengths];
    Rng rng(seed);
    for (int i = 0; i < samples; ++i) {
        SampledSpectrum weight(1);
        const auto collide = [&](const MajorantCollision& c) {
            const SampledSpectrum null =
                Max(c.sigmaMaj - medium.At(c.p, lambda).SigmaT(), SampledSpectrum(0));
            weight *= c.Tmaj * null / (c.Tmaj[0] * c.sigmaMaj[0]);
            return bool(weight);
        };
        const SampledSpectrum T = TrackCollisions(medium, kRay, kLength, rng.Uniform(), rng, lambda, collide);
        if (weight) weight *= T / T[0];
        for (int l = 0; l < kNumWavelengths; ++l) means[l].Add(double(weight[l]));
    }
    std::vector<Outcome> outcomes;
    for (int l = 0; l < kNumWavelengths; ++l)
        // The midpoint rule of a field with kinks and 20,000 steps, in floats.
        outcomes.push_back(ZTest(means[l], expected[size_t(l)], 2e-4 * expected[size_t(l)],
                                 fmt::format("transmittance at {} nm", lambda[l])));
    return WorstOf(outcomes);
}

// Power: standard errors are about 0.5 % of the transmittance; a bound too low where the density is high, or
// a cell left out, changes it by several per cent, see the control.
TEST(TransmittanceOfGrids, IsThatOfRayMarching) {
    for (const Named& named : kMedia) {
        const auto medium = MakeMedium(named.type, named.text);
        EXPECT_TRUE(Passes(FullTestName() + named.type, kAlpha,
                           [&](uint64_t seed) { return TrackedTransmittance(*medium, 40000, seed); }));
    }
}

/// A grid of densities whose bounds are too low by a factor.
class LowBounds final : public Medium {
  public:
    explicit LowBounds(float factor)
        : Medium({MakeIsotropicPhaseModel(), {}}),
          grid_({2, 1, 1}, std::vector<float>{1, 4}),
          majorants_(
              BoundUnitCube(Int3(32), [&](const Bounds3& box) { return factor * grid_.Maximum(box); })) {}
    MediumProperties At(Point3 p, const SampledWavelengths&) const override {
        return {SampledSpectrum(InUnitCube(p) ? grid_.Lookup(p) : 0.f), SampledSpectrum(0),
                SampledSpectrum(0)};
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths&) const override {
        return {majorants_, ray, tMax, SampledSpectrum(1)};
    }
    bool IsEmissive() const override { return false; }

  private:
    FloatGrid grid_;
    MajorantGrid majorants_;
};

TEST(TransmittanceOfGrids, ShowsBoundsThatAreTooLow) {
    const auto check = [](float factor) {
        return Passes(FullTestName(), kAlpha,
                      [&](uint64_t seed) { return TrackedTransmittance(LowBounds(factor), 40000, seed); });
    };
    EXPECT_TRUE(check(1));
    EXPECT_FALSE(check(0.8f)) << "control: 20 % too low";
}

/// A camera at (0.4, 0.45, -1) that looks along z through a box of interface material around the unit cube.
std::string SceneOf(const std::string& medium, const std::string& world, int maxDepth = 5) {
    return "LookAt 0.4 0.45 -1  0.4 0.45 0  0 1 0 Camera \"perspective\" \"float fov\" 1 Film \"rgb\" "
           "\"integer xresolution\" 1 "
           "\"integer yresolution\" 1 Sampler \"independent\" Integrator \"volpath\" \"integer maxdepth\" " +
           std::to_string(maxDepth) + " WorldBegin " + world + " MakeNamedMedium \"m\" \"string type\" " +
           medium +
           " MediumInterface \"m\" \"\" Material \"interface\" Translate 0.5 0.5 0.5 Shape \"sphere\" "
           "\"float radius\" 1";
}

/// Radiance along the middle of SceneOf's image of an absorbing, emitting medium, over white, by the midpoint
/// rule.
double MarchedEmission(const Medium& medium) {
    constexpr int kSteps = 20000;
    double sum = 0, depth = 0;
    const SampledWavelengths lambda = SomeWavelengths();
    const double white = double(ColorSpace::SRGB().Illuminant().Sample(lambda)[0]) / double(kCieYIntegral);
    for (int i = 0; i < kSteps; ++i) {
        const MediumProperties m = medium.At({0.4f, 0.45f, (float(i) + 0.5f) / kSteps}, lambda);
        const double sigma = double(m.sigma_a[0]) / kSteps;
        sum += std::exp(-depth - sigma / 2) * sigma * double(m.Le[0]) / white;
        depth += sigma;
    }
    return sum;
}

// Power: standard errors are below 0.7 %; a missing factor of the tent or of the density is tens of per cent.
TEST(EmissionOfGrids, IsThatOfRayMarching) {
    const std::string dark = " \"rgb sigma_s\" [0 0 0] ";
    const std::vector<Named> emitters = {
        {"uniformgrid", kGrid + dark + "\"rgb Le\" [1 1 1]"},
        {"uniformgrid",
         kGrid + dark + "\"rgb Le\" [1 1 1] \"float Lescale\" [0 1 2 3 0 0  1 0 2 0 1 1  3 3 1 0 2 1]"},
        {"rgbgrid",
         "\"integer nx\" 2 \"rgb sigma_a\" [4 4 4  1 1 1] \"rgb sigma_s\" [0 0 0  0 0 0] \"rgb Le\" "
         "[1 1 1  2 2 2]"},
    };
    for (size_t i = 0; i < emitters.size(); ++i) {
        const Named& e = emitters[i];
        const double expected = MarchedEmission(*MakeMedium(e.type, e.text));
        const RenderSetup setup = BuildText(SceneOf("\"" + std::string(e.type) + "\" " + e.text, ""));
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(i), kAlpha, [&](uint64_t seed) {
            return ZTest(CenterRadiance(setup, 20000, seed), expected, 1e-3 * expected, e.type);
        })) << e.type;
        EXPECT_FALSE(Passes(FullTestName() + std::to_string(i), kAlpha, [&](uint64_t seed) {
            return ZTest(CenterRadiance(setup, 20000, seed), 1.06 * expected, 1e-3 * expected, e.type);
        })) << "control: 6 %";
    }
}

// Power: the standard error is below 0.05 %, and the claim is 0.2 %.
TEST(FurnaceOfGrids, WithoutLossesIsWhite) {
    const std::vector<Named> scattering = {
        {"uniformgrid", kGrid + "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [1 1 1]"},
        {"uniformgrid", kGrid + "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0.4 1 1.4] \"float g\" 0.7"},
        {"cloud", "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [2 2 2]"},
        {"rgbgrid", "\"integer nx\" 2 \"rgb sigma_s\" [3 1 2  0.3 2 1] \"rgb sigma_a\" [0 0 0  0 0 0]"},
    };
    for (size_t i = 0; i < scattering.size(); ++i) {
        const Named& s = scattering[i];
        const RenderSetup setup = BuildText(
            SceneOf("\"" + std::string(s.type) + "\" " + s.text, "LightSource \"infinite\"", 10000));
        const int samples = 6000;
        const auto run = [&](uint64_t seed) { return CenterRadiance(setup, samples, seed); };
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(i), kAlpha,
                           [&](uint64_t seed) { return ZTest(run(seed), 1, 1e-5, s.type); }))
            << s.type << " " << i;
        const RunningMean mean = run(SeedOf(FullTestName()));
        EXPECT_NEAR(mean.Mean(), 1, 0.002)
            << s.type << " " << i << ", standard error " << mean.StandardError();
    }
}

}  // namespace
}  // namespace lacquer::test::media_test
