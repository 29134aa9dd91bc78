// Fits with a generator that was trained for some seconds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "materialgan/fit/embedding.h"
#include "materialgan/latent_fit.h"
#include "materialgan/procedural/procedural.h"
#include "materialgan/training/trainer.h"
#include "support/stopping_observer.h"

namespace lacquer::materialgan::fit_test {
namespace {

constexpr int kSize = 32, kSteps = 120;

using End = capture::FitResult::End;

std::string TemporaryPath(const std::string& name) {
    return (std::filesystem::temp_directory_path() /
            fmt::format("lacquer-fit-test-{}-{}.safetensors", name, ::getpid()))
        .string();
}

std::unique_ptr<MaterialPrior> TrainedPrior(int steps, int latentSize = 24) {
    ConfigureTorch(1);
    Trainer trainer(
        {.resolution = kSize, .mapsMax = 24, .mapsBase = 384, .latentSize = latentSize, .mappingLayers = 2},
        8, 1);
    for (int step = 0; step < steps; ++step) trainer.Step(double(step) / steps);
    const std::string path = TemporaryPath("prior");
    SaveGeneratorFile(trainer.Average(128), path);
    auto loaded = std::make_unique<MaterialPrior>(path);
    std::filesystem::remove(path);
    return loaded;
}

/// Trained once for all tests.
const MaterialPrior& Prior() {
    static const std::unique_ptr<MaterialPrior> prior = TrainedPrior(kSteps);
    return *prior;
}

/// Three views with flash to fit, and two held out with the light aside.
FitInput InputOf(const capture::Maps& maps) {
    FitInput input;
    input.views.size = 10.88;
    for (const auto& [x, y] : {std::array{-2.5, 2.5}, std::array{2.5, 0.}, std::array{0., -2.5}})
        input.views.views.push_back({"", {x, y, 16}, {x, y, 16}, false});
    for (const double x : {-6., 6.}) input.views.views.push_back({"", {0, 0, 16}, {x, -x, 10}, true});
    for (const capture::View& view : input.views.views)
        input.images.push_back(capture::RenderView(maps, input.views, view));
    return input;
}

const capture::Maps& Truth() {
    static const capture::Maps truth = ProceduralMaterial(Family::Cells, kSize, 77);
    return truth;
}

LatentFitOptions Start() {
    LatentFitOptions options;
    options.iterations = options.refinement.iterations = 0;
    return options;
}

TEST(LatentFit, ImprovesViewsThatItHasNotSeen) {
    const FitInput input = InputOf(Truth());
    const FitResult start = FitLatents(Prior(), input, Start());
    LatentFitOptions options;
    options.iterations = 80;
    const FitResult fit = FitLatents(Prior(), input, options);
    EXPECT_LT(fit.inputRmse, 0.8 * start.inputRmse);
    EXPECT_LT(fit.testRmse, 0.95 * start.testRmse);
    EXPECT_EQ(fit.losses.size(), 80u);
    EXPECT_EQ(fit.end, End::Finished);
    // Its latents make the maps that it had before they were refined.
    const capture::Maps again = Prior().Decode(fit.latents);
    for (size_t i = 0; i < again.values.size(); ++i)
        ASSERT_NEAR(again.values[i], fit.beforeRefinement.values[i], 1e-5);
}

TEST(LatentFit, EveryStrategyAndOptimizerDescends) {
    const FitInput input = InputOf(Truth());
    constexpr FitStart kStarts[] = {FitStart::Two, FitStart::Full, FitStart::Encoder};
    for (const int strategy : {1, 2, 3}) {
        LatentFitOptions options;
        options.iterations = 24;
        options.strategy = strategy;
        options.start = kStarts[strategy - 1];
        options.refinement.iterations = 0;
        options.optimizer = strategy == 2 ? FitOptimizer::Sign : FitOptimizer::Adam;
        options.features = strategy == 1 ? FitFeatures::Steerable : FitFeatures::None;
        if (strategy == 2) options.rateW = options.rateNoise = 0.01;
        const FitResult fit = FitLatents(Prior(), input, options);
        // Features count differently for w and for noise: there the halves are two losses.
        const size_t end = strategy == 1 ? fit.losses.size() / 2 - 1 : fit.losses.size() - 1;
        EXPECT_LT(fit.losses[end], 0.97 * fit.losses[0]) << strategy;
    }
}

// A converted checkpoint has no encoder: a fit embeds a smooth metal, unless its file has one. Fits write
// none.
TEST(LatentFit, TakesTheSmoothMetalOfTheFile) {
    class SeesEmbeddings final : public Observer {
      public:
        void Begin(const std::string& name, int64_t, const std::string&) override {
            count_ += name == "embedding a smooth metal";
        }
        int Count() const { return count_; }

      private:
        int count_ = 0;
    };
    const std::string path = TemporaryPath("start");
    GeneratorFile bare = Prior().File();
    bare.encoder.reset();
    bare.startLow.reset();
    SaveGeneratorFile(bare, path);
    const FitInput input = InputOf(Truth());
    LatentFitOptions options = Start();
    options.iterations = 4;
    options.start = FitStart::Two;
    std::vector<std::vector<double>> results;
    for (const int expected : {1, 0}) {
        SeesEmbeddings observer;
        results.push_back(FitLatents(MaterialPrior(path), input, options, &observer).maps.values);
        EXPECT_EQ(observer.Count(), expected);
        const GeneratorFile now = LoadGeneratorFile(path);
        ASSERT_EQ(now.startLow.has_value(), expected == 0);
        StyleGenerator generator(now.config, now.generator);
        generator.KeepKernels();
        if (expected == 1) {
            EXPECT_TRUE(StoreStartLow(now, EmbedSmoothMetal(now, generator, nullptr, nullptr).latents));
        }
    }
    EXPECT_EQ(results[0], results[1]);
    // A file that has changed since it was read is left alone.
    const GeneratorFile read = LoadGeneratorFile(path);
    std::filesystem::last_write_time(path,
                                     std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
    EXPECT_FALSE(StoreStartLow(read, MeanLatents(read)));
    std::filesystem::remove(path);
}

TEST(LatentFit, HasTheSameBitsAgain) {
    const FitInput input = InputOf(Truth());
    LatentFitOptions options;
    options.iterations = 15;
    const FitResult a = FitLatents(Prior(), input, options), b = FitLatents(Prior(), input, options);
    EXPECT_EQ(a.maps.values, b.maps.values);
    EXPECT_EQ(a.latents.wPlus, b.latents.wPlus);
    options.priorWeight = 0;
    EXPECT_NE(FitLatents(Prior(), input, options).maps.values, a.maps.values);
}

TEST(LatentFit, KeepsAGoodStateIfTheLossIsNotFinite) {
    FitInput input = InputOf(Truth());
    input.images[1].values[5] = std::numeric_limits<double>::quiet_NaN();
    LatentFitOptions options = Start();
    options.iterations = 5;
    const FitResult fit = FitLatents(Prior(), input, options);
    EXPECT_EQ(fit.end, End::NotFinite);
    for (const double v : fit.maps.values) ASSERT_TRUE(std::isfinite(v));
}

TEST(LatentFit, StopsWhereItIsAskedTo) {
    class StopsAfterSeven final : public Observer {
      public:
        void Advance(int64_t units) override { calls_ += int(units); }
        bool ShouldStop() override { return calls_ >= 7; }

      private:
        int calls_ = 0;
    };
    StopsAfterSeven observer;
    const capture::Maps texels = capture::ConstantMaps(kSize);
    const FitResult fit = FitLatents(Prior(), InputOf(Truth()), {}, &observer, &texels);
    EXPECT_EQ(fit.end, End::Stopped);
    EXPECT_EQ(fit.losses.size(), 7u);
    EXPECT_EQ(fit.maps.values, fit.beforeRefinement.values);
}

// From each part of a fit: texels, either start, latents, refinement.
TEST(LatentFit, GoesOnFromItsCheckpointToTheSameBits) {
    const FitInput input = InputOf(Truth());
    LatentFitOptions options;
    options.iterations = 25;
    options.start = FitStart::Two;
    options.testEvery = 10;
    const auto run = [&](capture::FitCheckpoint* checkpoint, Observer* observer,
                         std::vector<capture::FitStep>* steps) {
        options.checkpoint = checkpoint;
        options.afterStep = [=](const capture::FitStep& step) { steps->push_back(step); };
        return FitLatents(Prior(), input, options, observer);
    };
    std::vector<capture::FitStep> wholeSteps;
    const FitResult whole = run(nullptr, nullptr, &wholeSteps);
    const std::string path = TemporaryPath("checkpoint");
    for (const int units : {3, 25, 40, 60, 90}) {
        std::vector<capture::FitStep> ignored, steps;
        capture::FitCheckpoint first(path, {});
        lacquer::test::StoppingObserver observer(units);
        EXPECT_EQ(run(&first, &observer, &ignored).end, End::Stopped) << units;
        capture::FitCheckpoint second(path, {});
        second.Load();
        const FitResult rest = run(&second, nullptr, &steps);
        EXPECT_EQ(rest.end, End::Finished);
        EXPECT_EQ(rest.maps.values, whole.maps.values) << units;
        EXPECT_EQ(rest.latents.wPlus, whole.latents.wPlus);
        EXPECT_EQ(rest.losses, whole.losses);
        ASSERT_EQ(steps.size(), wholeSteps.size());
        for (size_t i = 0; i < steps.size(); ++i) EXPECT_EQ(steps[i].testRmse, wholeSteps[i].testRmse);
    }
    std::filesystem::remove(path);
}

TEST(DoubtOf, IsOfOnePhotographAndOfWhatTexelsExplainMuchBetter) {
    FitResult fit;
    fit.unrefinedRmse = 0.02;
    EXPECT_EQ(DoubtOf(fit, 0.004, 3), "");
    EXPECT_NE(DoubtOf(fit, 0.003, 3).find("0.02"), std::string::npos);
    EXPECT_NE(DoubtOf(fit, 0.02, 1), "");
}

TEST(LatentFit, WrongInputsAreNamed) {
    const auto message = [](const FitInput& input) -> std::string {
        try {
            FitLatents(Prior(), input, Start());
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "none";
    };
    FitInput input = InputOf(Truth());
    input.images.pop_back();
    EXPECT_EQ(message(input), "as many images as views are expected");
    input = InputOf(Truth());
    input.images[2] = capture::Halved(input.images[2]);
    EXPECT_EQ(message(input), "images have to have the size of the maps");
    input = InputOf(ProceduralMaterial(Family::Cells, 16, 1));
    EXPECT_EQ(message(input), "images of size 16, and the generator makes 32");
    for (capture::View& view : input.views.views) view.isTest = true;
    EXPECT_EQ(message(input), "no view is to be fitted");
}

// The refinement's own errors are those of capture; here from what the encoder started from.
TEST(LatentFit, StartsFromTheTexelsThatItIsGiven) {
    const FitInput input = InputOf(Truth());
    LatentFitOptions options = Start();
    const FitResult own = FitLatents(Prior(), input, options);
    EXPECT_EQ(own.texels.size, kSize);
    EXPECT_EQ(FitLatents(Prior(), input, options, nullptr, &own.texels).maps.values, own.maps.values);
    EXPECT_NE(FitLatents(Prior(), input, options, nullptr, &Truth()).maps.values, own.maps.values);
}

// The order of errors of the paper: more latents embed better, and noise alone cannot.
TEST(ProjectMaps, LargerSpacesEmbedBetter) {
    const auto error = [](LatentSpace space) { return ProjectMaps(Prior(), Truth(), space, 100).rmse; };
    const double noise = error(LatentSpace::Noise), w = error(LatentSpace::W),
                 plus = error(LatentSpace::WPlus), all = error(LatentSpace::WPlusNoise);
    EXPECT_LT(all, plus);
    EXPECT_LT(plus, w);
    EXPECT_LT(all, noise);
}

TEST(MaterialPrior, LatentsComeBackFromAFile) {
    const Latents latents = Prior().Encode(Truth());
    const std::string path = TemporaryPath("latents");
    SaveLatents(latents, Prior(), path);
    const Latents read = LoadLatents(path, Prior());
    EXPECT_EQ(read.wPlus, latents.wPlus);
    EXPECT_EQ(read.noise, latents.noise);
    EXPECT_THROW(LoadLatents(path, *TrainedPrior(0, 16)), FileError) << "of another shape";
    EXPECT_THROW(LoadLatents(path, *TrainedPrior(1)), FileError) << "of other weights";
    std::filesystem::remove(path);
}

TEST(MaterialPrior, MorphsBetweenItsEnds) {
    const Latents a = Prior().Encode(Truth()), b = Prior().Encode(ProceduralMaterial(Family::Wood, kSize, 1));
    const std::vector<capture::Maps> morph = Prior().Morph(a, b, 3);
    ASSERT_EQ(morph.size(), 3u);
    EXPECT_EQ(morph[0].values, Prior().Decode(a).values);
    EXPECT_EQ(morph[2].values, Prior().Decode(b).values);
    EXPECT_EQ(BlendMaps(morph[0], morph[2], 0).Channel(0)[5], morph[0].Channel(0)[5]);
}

TEST(MaterialPrior, SamplesDependOnTheSeedAndOnPsi) {
    const auto one = Prior().Sample(2, 1, 1);
    EXPECT_EQ(one[0].values, Prior().Sample(1, 1, 1)[0].values);
    EXPECT_NE(one[0].values, one[1].values);
    EXPECT_NE(Prior().Sample(1, 0.5, 1)[0].values, one[0].values);
}

}  // namespace
}  // namespace lacquer::materialgan::fit_test
