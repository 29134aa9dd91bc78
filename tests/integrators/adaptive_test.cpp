// Adaptive sampling: how samples are divided among pixels, that no pixel is biased by it, that any division
// of the work gives the same bits, and where a render stops that is to come to a noise level.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "integrators/render_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/render_state.h"
#include "pbrt/integrators/noise_level.h"
#include "pbrt/integrators/pilot_samples.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/integrators/window_sums.h"
#include "support/stopping_observer.h"

namespace lacquer::adaptive_test {
namespace {

constexpr Bounds2i kPixels{{3, 5}, {67, 53}};
constexpr int64_t kNever = int64_t(1) << 60;

double MeanShare(const SampleShares& shares) {
    double sum = 0;
    for (const uint8_t share : shares.Shares()) sum += share;
    return sum / double(shares.Shares().size()) / SampleShares::kUnit;
}

TEST(SampleShares, RangesOfSamplesFollowOneAnother) {
    std::vector<uint8_t> all;
    for (int share = 1; share <= SampleShares::kMax; ++share) all.push_back(uint8_t(share));
    const SampleShares shares({{0, 0}, {SampleShares::kMax, 1}}, all);
    for (int x = 0; x < SampleShares::kMax; ++x) {
        const Int2 p(x, 0);
        EXPECT_EQ(shares.SamplesOf(p, 0), 0);
        EXPECT_GE(shares.SamplesOf(p, 1), 1) << "each pixel has a sample of each image";
        EXPECT_EQ(shares.SamplesOf(p, SampleShares::kUnit), x + 1);
        for (int samples = 0; samples < 40; ++samples) {
            EXPECT_LE(shares.SamplesOf(p, samples), shares.SamplesOf(p, samples + 1));
            const int64_t taken = shares.SamplesOf(p, samples);
            EXPECT_GE(shares.MostOf(p, taken), samples);
            EXPECT_LE(shares.LeastOf(p, taken), samples);
            EXPECT_LE(shares.SamplesOf(p, shares.MostOf(p, taken)), taken);
            EXPECT_GE(shares.SamplesOf(p, shares.LeastOf(p, taken)), taken);
        }
    }
}

TEST(SampleShares, TheirMeanIsOneAndTheirLimitsHold) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (const double spread : {0.0, 0.5, 2.0, 6.0}) {
        std::vector<double> density;
        for (int64_t i = 0; i < kPixels.Area(); ++i)
            density.push_back(std::exp(spread * double(rng.Uniform() - 0.5f)));
        const SampleShares shares = SharesInProportion(kPixels, density);
        EXPECT_NEAR(MeanShare(shares), 1, 0.01) << spread;
        EXPECT_LE(MeanShare(shares), 1) << spread;
        for (size_t i = 0; i < density.size(); ++i)
            for (size_t j = 0; j < i && j < 50; ++j) {
                if (density[i] > density[j]) {
                    EXPECT_GE(shares.Shares()[i], shares.Shares()[j]);
                }
            }
    }
    // One pixel in a thousand has all the noise: it gets the most there is, and all others the least.
    std::vector<double> density(size_t(kPixels.Area()), 0.0);
    density[700] = 1;
    const SampleShares shares = SharesInProportion(kPixels, density);
    EXPECT_EQ(shares.Shares()[700], SampleShares::kMax);
    EXPECT_EQ(shares.Shares()[701], 1);
}

/// Pilots of pixels with the given deviations.
std::vector<PilotPixel> PilotsOf(const std::vector<double>& deviations, Rng* rng) {
    std::vector<PilotPixel> pilots;
    for (const double s : deviations) {
        const auto noise = [&] { return float(s * std::sqrt(3.0) * (2.0 * double(rng->Uniform()) - 1)); };
        const float a = 1 + noise(), b = 1 + noise();
        pilots.push_back({RGB((a + b) / 2), RGB(a - b), 4});
    }
    return pilots;
}

TEST(SampleShares, NoisyPixelsGetMore) {
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> deviations;
    for (int64_t i = 0; i < kPixels.Area(); ++i) deviations.push_back(i % kPixels.Width() < 16 ? 0.4 : 0.1);
    const SampleShares shares = SharesByPilots(kPixels, 1, PilotsOf(deviations, &rng));
    EXPECT_NEAR(MeanShare(shares), 1, 1e-3);
    test::RunningMean noisy, quiet;
    for (size_t i = 0; i < deviations.size(); ++i)
        if (const size_t x = i % size_t(kPixels.Width()); x < 8)
            noisy.Add(shares.Shares()[i]);
        else if (x >= 34)
            quiet.Add(shares.Shares()[i]);
    // In proportion to the deviations to the power of 0.8: see sample_shares.cpp.
    EXPECT_NEAR(noisy.Mean() / quiet.Mean(), std::pow(4, 0.8), 0.3);
    // Far from the edge between them, which windows blur, the shares have hardly any noise.
    EXPECT_LT(std::sqrt(quiet.Variance()) / quiet.Mean(), 0.15);
}

TEST(SampleShares, EvenNoiseAndNoNoiseLeaveThemEven) {
    Rng rng(test::SeedOf(test::FullTestName()));
    const std::vector<double> even(size_t(kPixels.Area()), 0.2);
    EXPECT_TRUE(SharesByPilots(kPixels, 1, PilotsOf(even, &rng)).AreEven());
    const SampleShares none =
        SharesByPilots(kPixels, 1, PilotsOf(std::vector<double>(even.size(), 0.0), &rng));
    for (const uint8_t share : none.Shares()) EXPECT_EQ(share, SampleShares::kUnit);
}

/// Noise that differs from pixel to pixel: what a pilot tells of its own pixel looks like much, but its
/// neighbours know nothing of it. Shares that follow both would gain 1.15 by pilots that they know already.
TEST(SampleShares, NoiseThatNeighboursDoNotShareLeavesThemEven) {
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> deviations;
    for (int64_t i = 0; i < kPixels.Area(); ++i)
        deviations.push_back(0.1 * std::exp(2 * double(rng.Uniform()) - 1));
    EXPECT_TRUE(SharesByPilots(kPixels, 1, PilotsOf(deviations, &rng)).AreEven());
}

/// Most windows of pilots have seen nothing of noise that is rare, and it is as much everywhere.
TEST(SampleShares, RareNoiseThatIsEvenLeavesThemEven) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (const double chance : {0.05, 0.02, 0.005})
        for (const float background : {0.0f, 1.0f}) {
            const auto draw = [&] {
                return background + (double(rng.Uniform()) < chance ? float(1 / chance) : 0.0f);
            };
            std::vector<PilotPixel> pilots;
            for (int64_t i = 0; i < kPixels.Area(); ++i) {
                const float a = draw(), b = draw();
                pilots.push_back({RGB((a + b) / 2), RGB(a - b), 4});
            }
            EXPECT_TRUE(SharesByPilots(kPixels, 1, pilots).AreEven()) << chance << " " << background;
        }
}

/// However bright: a large image hardly notices it. One half of it is noisier than the other, or all would
/// get the same.
TEST(SampleShares, OneBrightPilotDrawsFewSamples) {
    constexpr Bounds2i kLarge{{0, 0}, {256, 256}};
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> deviations;
    for (int64_t i = 0; i < kLarge.Area(); ++i) deviations.push_back(i % 256 < 128 ? 0.05 : 0.8);
    std::vector<PilotPixel> pilots = PilotsOf(deviations, &rng);
    const SampleShares without = SharesByPilots(kLarge, 1, pilots);
    EXPECT_FALSE(without.AreEven());
    const Int2 bright(192, 128);
    for (const float value : {1e2f, 1e6f, 1e15f}) {
        pilots[size_t(bright.y * 256 + bright.x)] = {RGB(value / 2), RGB(value), 4};
        const SampleShares shares = SharesByPilots(kLarge, 1, pilots);
        EXPECT_NEAR(MeanShare(shares), 1, 1e-3) << value;
        double drawn = 0;
        test::RunningMean far, farWithout;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x) {
                const auto shareOf = [&](const SampleShares& of) {
                    return double(of.Shares()[size_t(y * 256 + x)]) / SampleShares::kUnit;
                };
                if (std::max(std::abs(x - bright.x), std::abs(y - bright.y)) > 32) {
                    far.Add(shareOf(shares));
                    farWithout.Add(shareOf(without));
                } else {
                    drawn += shareOf(shares) - shareOf(without);
                }
            }
        EXPECT_GT(drawn, 100) << value;
        EXPECT_LT(drawn, 3000) << value;
        EXPECT_GT(far.Mean(), 0.95 * farWithout.Mean()) << value;
    }
}

/// An edge of noise, two pixels wide, in an image of 64 samples: windows of many pilots each would not see
/// it.
TEST(SampleShares, NarrowNoiseGetsMore) {
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> deviations;
    const auto isEdge = [](size_t i) { return i % size_t(kPixels.Width()) / 2 == 15; };
    for (size_t i = 0; i < size_t(kPixels.Area()); ++i) deviations.push_back(isEdge(i) ? 0.8 : 0.05);
    const SampleShares shares = SharesByPilots(kPixels, 1, PilotsOf(deviations, &rng));
    double even = 0, adaptive = 0;
    for (size_t i = 0; i < deviations.size(); ++i) {
        even += Sqr(deviations[i]);
        adaptive += Sqr(deviations[i]) * SampleShares::kUnit / shares.Shares()[i];
    }
    EXPECT_LT(adaptive / even, 0.5);
    // What one block of 4 x 4 pixels in two would have of it: the control.
    std::vector<PilotPixel> few;
    const Int2 blocks = PilotBlocksOf(kPixels, 4);
    for (int k = 0; k < blocks.x * blocks.y; ++k) few.push_back({RGB(1), RGB(k % 2 ? 0.2f : 0.05f), 4});
    const SampleShares coarse = SharesByPilots(kPixels, 4, few);
    double blurred = 0;
    for (size_t i = 0; i < deviations.size(); ++i)
        blurred += Sqr(deviations[i]) * SampleShares::kUnit / coarse.Shares()[i];
    EXPECT_GT(blurred / even, 0.6);
}

TEST(PilotPlan, TakesAThirtySecondOfTheSamples) {
    for (const int64_t pixels :
         {int64_t(1000), int64_t(2000000), int64_t(4096) * 2160, int64_t(32768) * 32768})
        for (int samples = 1; samples <= 100000; samples = samples * 3 / 2 + 1) {
            const PilotPlan plan = PilotPlanOf(samples, pixels);
            const double inBlock = 2.0 * plan.half, part = inBlock / (double(samples) * Sqr(plan.spacing));
            EXPECT_LE(part, 1 / 32.0) << samples;
            if (inBlock < 32 && plan.spacing < 8) {
                EXPECT_GT(part, 1 / 64.1) << samples;
            }
            if (pixels <= 4096 * 2160) {
                EXPECT_LE(pixels / Sqr(plan.spacing), 2500000);
            }
        }
    EXPECT_EQ(PilotPlanOf(64, 1000000).spacing, 1);
    EXPECT_EQ(PilotPlanOf(64, 4096 * 2160).spacing, 2);
}

/// The mean over images of estimates of a rare event. Each pixel has a share by its own pilots alone: nothing
/// smooths away what they do to it.
/// @param countsPilots  pilots are part of the estimate: what must not be
test::Outcome BiasOf(bool countsPilots, uint64_t seed) {
    constexpr double kChance = 0.04, kValue = 25;
    constexpr Bounds2i kImage{{0, 0}, {16, 16}};
    Rng rng(seed);
    const auto draw = [&] { return double(rng.Uniform()) < kChance ? kValue : 0.0; };
    test::RunningMean mean;
    for (int trial = 0; trial < test::Scaled(1000); ++trial) {
        std::vector<double> pilots, density;
        for (int64_t i = 0; i < kImage.Area(); ++i) {
            const double a = draw(), b = draw();
            pilots.push_back(a + b);
            density.push_back(1 + std::abs(a - b));
        }
        const SampleShares shares = SharesInProportion(kImage, density);
        double sum = 0;
        for (int64_t i = 0; i < kImage.Area(); ++i) {
            const auto count = int(shares.SamplesOf({int(i % 16), int(i / 16)}, 8));
            double pixel = countsPilots ? pilots[size_t(i)] : 0;
            for (int k = 0; k < count; ++k) pixel += draw();
            sum += pixel / (countsPilots ? count + 2 : count);
        }
        mean.Add(sum / double(kImage.Area()));
    }
    return test::ZTest(mean, kChance * kValue, 1e-6, countsPilots ? "with pilots" : "without pilots");
}

TEST(AdaptiveSampling, NoPixelIsBiased) {
    EXPECT_TRUE(test::Passes(test::FullTestName(), 1e-4, [](uint64_t seed) { return BiasOf(false, seed); }));
}
TEST(AdaptiveSampling, PilotsThatCountWouldBias) {
    EXPECT_LT(BiasOf(true, test::SeedOf(test::FullTestName())).pValue, 1e-6);
}

/// A small light that paths find by chance alone, over half of a floor.
std::string SceneOf(const std::string& sampler, int resolution, int samples, int seed) {
    return "LookAt 0 3 -4 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 50 Sampler \"" + sampler +
           "\" \"integer seed\" " + std::to_string(seed) +
           (sampler == "stratified"
                ? " \"integer xsamples\" " + std::to_string(samples) + " \"integer ysamples\" 1"
                : " \"integer pixelsamples\" " + std::to_string(samples)) +
           " PixelFilter \"box\" Integrator \"randomwalk\" \"integer maxdepth\" 3 Film \"rgb\""
           " \"integer xresolution\" " +
           std::to_string(resolution) + " \"integer yresolution\" " + std::to_string(resolution) + R"(
        WorldBegin
        AttributeBegin AreaLightSource "diffuse" "rgb L" [30 30 30]
            Translate -1 1 0 Shape "sphere" "float radius" 0.3 AttributeEnd
        Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
        Shape "bilinearmesh" "point3 P" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]
    )";
}

SampleShares SharesOfSetup(const RenderSetup& setup, int samples) {
    Observer silent;
    return MeasureShares(*setup.scene, *setup.integrator, *setup.film, {samples, setup.generatorSeed, {}},
                         silent);
}

/// The mean of an image over many seeds.
test::RunningMean MeanOfImages(bool isAdaptive, int images, int firstSeed) {
    test::RunningMean mean;
    for (int i = 0; i < images; ++i) {
        const RenderSetup setup = test::BuildText(SceneOf("zsobol", 8, 8, firstSeed + i));
        RenderOptions options = RenderOptionsOf(setup);
        options.endSample = 4;
        const SampleShares shares = SharesOfSetup(setup, 256);
        if (isAdaptive) options.shares = &shares;
        test::RenderAll(setup, options);
        mean.Add(test::PixelLuminance(*setup.film->Develop()).Mean());
    }
    return mean;
}

TEST(AdaptiveSampling, ImagesHaveTheMeanOfEvenOnes) {
    const int images = test::Scaled(1200);
    EXPECT_TRUE(test::Passes(test::FullTestName(), 1e-4, [&](uint64_t seed) {
        const int first = int(seed % 1000000) * 1000;
        const test::RunningMean adaptive = MeanOfImages(true, images, first);
        const test::RunningMean even = MeanOfImages(false, images, first + 100000);
        const double error = std::hypot(adaptive.StandardError(), even.StandardError());
        // Power: a bias of 5 % is seen almost always.
        EXPECT_LT(error, 0.0125 * even.Mean() * std::sqrt(1200.0 / images));
        return test::Outcome{test::NormalTwoSided((adaptive.Mean() - even.Mean()) / error), "means differ"};
    }));
}

/// One render with shares, which can be left and taken up.
struct AdaptivePart {
    explicit AdaptivePart(const std::string& sampler)
        : setup(test::BuildText(SceneOf(sampler, 24, 1024, 7))), shares(SharesOfSetup(setup, 1024)) {}
    RenderStats Render(int first, int end, int64_t units, bool resumes = false) {
        RenderOptions options = RenderOptionsOf(setup);
        options.firstSample = first;
        options.endSample = end;
        options.shares = &shares;
        options.resumes = resumes;
        test::StoppingObserver observer(units);
        return lacquer::Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options,
                               observer);
    }
    std::vector<float> Pixels() const { return setup.film->Develop()->Pixels(); }
    RenderSetup setup;
    SampleShares shares;
};

TEST(AdaptiveSampling, EveryPixelGetsItsShare) {
    AdaptivePart part("zsobol");
    ASSERT_NEAR(MeanShare(part.shares), 1, 0.05);
    const auto [least, most] = std::minmax_element(part.shares.Shares().begin(), part.shares.Shares().end());
    EXPECT_LT(*least, *most) << "this scene has no uneven noise";
    const RenderStats stats = part.Render(0, 12, kNever);
    EXPECT_EQ(stats.samplesPerPixel, 12);
    EXPECT_EQ(stats.maxSamples, 12);
    int64_t sum = 0;
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x) {
            EXPECT_EQ(part.setup.film->SampleCount({x, y}), part.shares.SamplesOf({x, y}, 12));
            sum += part.setup.film->SampleCount({x, y});
        }
    EXPECT_EQ(stats.samples, sum);
}

class AdaptiveParts : public testing::TestWithParam<const char*> {};

/// Ranges that begin and end anywhere, rendered by other numbers of threads.
TEST_P(AdaptiveParts, RangesGiveTheSameBits) {
    AdaptivePart whole(GetParam());
    whole.Render(0, 29, kNever);
    AdaptivePart sum(GetParam());
    int threads = 1;
    for (const auto& [first, end] : {std::pair(13, 29), std::pair(0, 1), std::pair(1, 13)}) {
        const ThreadLimit limit(threads++);
        AdaptivePart part(GetParam());
        ASSERT_EQ(part.shares.Shares(), whole.shares.Shares());
        EXPECT_EQ(part.Render(first, end, kNever).samplesPerPixel, end - first);
        std::vector<StateArray> from, to;
        part.setup.film->AppendState(&from);
        sum.setup.film->AppendState(&to);
        std::vector<StoredArray> stored;
        for (const StateArray& array : from)
            std::visit(
                [&](auto* values) {
                    if constexpr (!std::is_same_v<decltype(values), IdCounts*>)
                        stored.push_back({array.name, *values});
                },
                array.values);
        const Bounds2i pixels = part.setup.film->PixelBounds();
        ASSERT_EQ(AddState(stored, to, pixels, pixels), "");
    }
    EXPECT_EQ(sum.Pixels(), whole.Pixels());
}

TEST_P(AdaptiveParts, StoppedAndResumedTheyGiveTheSameBits) {
    AdaptivePart whole(GetParam());
    whole.Render(0, 29, kNever);
    AdaptivePart part(GetParam());
    Rng rng(test::SeedOf(test::FullTestName()));
    int stops = 0;
    for (bool resumes = false;; resumes = true, ++stops) {
        const ThreadLimit threads(1 + stops % 3);
        const RenderStats stats = part.Render(0, 29, 1 + rng.UniformInt(6000), resumes);
        if (!stats.interrupted) break;
        EXPECT_LE(stats.samplesPerPixel, 29);
    }
    EXPECT_GT(stops, 1);
    EXPECT_EQ(part.Pixels(), whole.Pixels());
}

INSTANTIATE_TEST_SUITE_P(Samplers, AdaptiveParts,
                         testing::Values("zsobol", "halton", "stratified", "independent", "pmj02bn"),
                         [](const auto& instance) { return std::string(instance.param); });

/// A floor under a sky, with the lights of `text`.
RenderSetup NoiseScene(int seed, int samples, const std::string& sampler) {
    BuildOptions options;
    options.film.keepsHalves = true;
    return BuildScene(
        ParseText("LookAt 0 2 -4 0 0.3 0 0 1 0 Camera \"perspective\" \"float fov\" 45 Sampler \"" + sampler +
                      "\" \"integer seed\" " + std::to_string(seed) + " \"integer pixelsamples\" " +
                      std::to_string(samples) + R"(
        PixelFilter "box" Integrator "path" "integer maxdepth" 2
        Film "rgb" "integer xresolution" 48 "integer yresolution" 36 WorldBegin
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 8 7]
            Translate 0 3 0 Rotate 90 1 0 0 Shape "disk" AttributeEnd
        Material "diffuse" "rgb reflectance" [0.6 0.4 0.2]
        Shape "bilinearmesh" "point3 P" [-9 0 -9  9 0 -9  -9 0 9  9 0 9]
        Translate 0 0.6 0 Shape "sphere" "float radius" 0.6
    )",
                  "scene.pbrt", "", nullptr),
        options, nullptr);
}

/// By many images: what NoiseLevel() says of one.
double MeasuredNoise(int images, int samples, const std::string& sampler) {
    std::vector<RGB> sums(48 * 36, RGB(0)), squares(48 * 36, RGB(0));
    for (int seed = 1; seed <= images; ++seed) {
        const RenderSetup setup = NoiseScene(seed, samples, sampler);
        test::RenderAll(setup);
        const std::unique_ptr<Image> image = setup.film->Develop();
        for (int i = 0; i < 48 * 36; ++i)
            for (int c = 0; c < 3; ++c) {
                const float value = image->Get({i % 48, i / 48}, c);
                sums[size_t(i)][c] += value;
                squares[size_t(i)][c] += value * value;
            }
    }
    const auto n = float(images);
    for (RGB& sum : sums) sum /= n;
    std::vector<double> relative = SquaredScales({48, 36}, sums, kNoiseScaleWindow);
    WindowSums errors({48, 36});
    for (size_t i = 0; i < relative.size(); ++i) {
        const RGB variance = (squares[i] / n - sums[i] * sums[i]) * (n / (n - 1));
        errors.Set({int(i % 48), int(i / 48)},
                   std::max(0.0, double(variance.x + variance.y + variance.z)) / (3 * relative[i]));
    }
    errors.GrowTo(8);
    for (size_t i = 0; i < relative.size(); ++i)
        relative[i] = std::sqrt(errors.Mean({int(i % 48), int(i / 48)}));
    const auto rank = relative.begin() + ptrdiff_t(0.95 * double(relative.size() - 1));
    std::nth_element(relative.begin(), rank, relative.end());
    return *rank;
}

/// What NoiseLevel() says of an image with so many samples, over what many images say.
double NoiseRatio(int images, int samples, const std::string& sampler) {
    const RenderSetup setup = NoiseScene(1000, samples, sampler);
    RenderOptions options;
    options.noiseTarget = 1e-9;
    return *test::RenderAll(setup, options).noise / MeasuredNoise(images, samples, sampler);
}

TEST(NoiseLevelLong, IsTheErrorThatImagesHave) {
    // One image tells the variance of 64 pixels by as many squares; the percentile takes the larger ones.
    const double independent = NoiseRatio(60, 64, "independent");
    EXPECT_GT(independent, 0.85);
    EXPECT_LT(independent, 1.35);
    // Halves of a well distributed set are less well distributed.
    for (const char* sampler : {"zsobol", "halton", "sobol"}) {
        const double ratio = NoiseRatio(40, 64, sampler);
        EXPECT_GT(ratio, 0.85) << sampler;
        EXPECT_LT(ratio, 4) << sampler;
    }
}

/// Of pixels with edges: halves that are strips of a pixel differ however many samples there are.
TEST(NoiseLevelLong, FallsWithTheNoise) {
    for (const char* sampler : {"halton", "sobol", "zsobol"}) {
        const double ratio = NoiseRatio(12, 512, sampler);
        EXPECT_GT(ratio, 0.8) << sampler;
        EXPECT_LT(ratio, 4) << sampler;
    }
}

RenderStats RenderToNoise(const RenderSetup& setup, double target, int64_t units, bool resumes,
                          const SampleShares* shares = nullptr) {
    RenderOptions options = RenderOptionsOf(setup);
    options.noiseTarget = target;
    options.resumes = resumes;
    options.shares = shares;
    test::StoppingObserver observer(units);
    return Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, observer);
}

TEST(NoiseTarget, StopsThereAndNotBefore) {
    int before = 0;
    for (const double target : {0.2, 0.1, 0.05}) {
        const RenderSetup setup = NoiseScene(1, 1024, "zsobol");
        const RenderStats stats = RenderToNoise(setup, target, kNever, false);
        EXPECT_TRUE(stats.reachedNoise);
        EXPECT_FALSE(stats.timedOut);
        ASSERT_TRUE(stats.noise);
        EXPECT_LE(*stats.noise, target);
        EXPECT_GT(*stats.noise, target / 4);
        EXPECT_GT(stats.samplesPerPixel, before);
        EXPECT_EQ(stats.samplesPerPixel, stats.maxSamples);
        before = stats.samplesPerPixel;
    }
    // More than the scene allows.
    const RenderSetup setup = NoiseScene(1, 16, "zsobol");
    const RenderStats stats = RenderToNoise(setup, 1e-4, kNever, false);
    EXPECT_FALSE(stats.reachedNoise);
    EXPECT_FALSE(stats.timedOut);
    EXPECT_EQ(stats.samplesPerPixel, 16);
    ASSERT_TRUE(stats.noise);
    EXPECT_GT(*stats.noise, 1e-4);
}

TEST(NoiseTarget, StoppedAndResumedItGivesTheSameBits) {
    for (const bool isAdaptive : {false, true}) {
        const RenderSetup whole = NoiseScene(1, 1024, "zsobol");
        const SampleShares shares = SharesOfSetup(whole, 64);
        const RenderStats stats = RenderToNoise(whole, 0.06, kNever, false, isAdaptive ? &shares : nullptr);
        ASSERT_TRUE(stats.reachedNoise);
        const RenderSetup parts = NoiseScene(1, 1024, "zsobol");
        Rng rng(test::SeedOf(test::FullTestName()));
        int stops = 0;
        for (bool resumes = false;; resumes = true, ++stops) {
            const ThreadLimit threads(1 + stops % 3);
            const RenderStats part = RenderToNoise(parts, 0.06, 1 + rng.UniformInt(40000), resumes,
                                                   isAdaptive ? &shares : nullptr);
            if (!part.interrupted) {
                EXPECT_EQ(part.samplesPerPixel, stats.samplesPerPixel);
                break;
            }
        }
        EXPECT_GT(stops, 0);
        EXPECT_EQ(parts.film->Develop()->Pixels(), whole.film->Develop()->Pixels());
    }
}

}  // namespace
}  // namespace lacquer::adaptive_test
