#include "pbrt/integrators/render.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <set>
#include <thread>

#include "integrators/render_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::render_test {
namespace {

using test::BuildText;
using test::RenderAll;

/// Something of everything that could depend on order: rough reflection, stochastic alpha and mixtures,
/// motion, a lens.
std::string Everything(const std::string& sampler) {
    return R"(LookAt 0 1 -5  0 0.5 0  0 1 0
        Camera "perspective" "float fov" 45 "float lensradius" 0.05 "float focaldistance" 5
        Film "rgb" "integer xresolution" 37 "integer yresolution" 23
        PixelFilter "mitchell"
        Sampler )" +
           sampler + R"(
        Integrator "path" "integer maxdepth" 4
        WorldBegin
        LightSource "infinite" "rgb L" [0.2 0.3 0.5]
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 8 7]
            Translate 0 3 0 Rotate 90 1 0 0 Shape "disk" AttributeEnd
        Texture "check" "spectrum" "checkerboard"
            "rgb tex1" [0.1 0.7 0.2] "rgb tex2" [0.8 0.8 0.8] "float uscale" 8 "float vscale" 8
        MakeNamedMaterial "a" "string type" "conductor" "float roughness" 0.2
        MakeNamedMaterial "b" "string type" "diffuse" "texture reflectance" "check"
        AttributeBegin Material "mix" "string materials" ["a" "b"] "float amount" 0.5
            Translate -1 0.7 0 Shape "sphere" "float radius" 0.7 AttributeEnd
        AttributeBegin ActiveTransform EndTime Translate 0.4 0.3 0 ActiveTransform All
            Material "dielectric" Translate 1 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd
        NamedMaterial "b"
        Shape "bilinearmesh" "point3 P" [-5 0 -5  5 0 -5  -5 0 5  5 0 5] "float alpha" 0.7
    )";
}
bool SameBits(const Image& a, const Image& b) {
    return a.Pixels().size() == b.Pixels().size() &&
           std::memcmp(a.Pixels().data(), b.Pixels().data(), a.Pixels().size() * sizeof(float)) == 0;
}
std::unique_ptr<Image> WithThreads(const std::string& text, int threads) {
    const ThreadLimit limit(threads);
    const RenderSetup setup = BuildText(text);
    const RenderStats stats = RenderAll(setup);
    EXPECT_GE(stats.threads, threads);
    EXPECT_EQ(stats.badSamples, 0);
    return setup.film->Develop();
}

TEST(Render, PixelsDoNotDependOnTheNumberOfThreads) {
    for (const std::string& name : Registry<SamplerKind>::Names()) {
        const std::string text =
            Everything("\"" + name + "\"" + (name == "stratified" ? "" : " \"integer pixelsamples\" 16"));
        const auto one = WithThreads(text, 1);
        EXPECT_FALSE(one->HasNonFinite());
        EXPECT_TRUE(SameBits(*one, *WithThreads(text, 2))) << name;
        EXPECT_TRUE(SameBits(*one, *WithThreads(text, 7))) << name;
    }
}

TEST(Render, PixelsDoNotDependOnPassesOrTiles) {
    const std::string text = Everything("\"zsobol\" \"integer pixelsamples\" 16");
    const RenderSetup whole = BuildText(text), pieces = BuildText(text);
    RenderAll(whole);
    for (const auto& [first, end] : {std::pair(0, 3), std::pair(3, 4), std::pair(4, 16)}) {
        RenderOptions options;
        options.firstSample = first;
        options.endSample = end;
        const RenderStats stats = RenderAll(pieces, options);
        EXPECT_EQ(stats.samplesPerPixel, end - first);
        EXPECT_EQ(stats.cameraRays, int64_t(end - first) * 37 * 23);
    }
    EXPECT_TRUE(SameBits(*whole.film->Develop(), *pieces.film->Develop()));

    // A crop window cuts the tiles elsewhere.
    BuildOptions options;
    options.film.pixelBounds = Bounds2i{{5, 7}, {30, 20}};
    const RenderSetup crop = BuildScene(ParseText(text, "scene.pbrt", "", nullptr), options, nullptr);
    RenderAll(crop);
    const auto part = crop.film->Develop(), all = whole.film->Develop();
    for (int y = 7; y < 20; ++y)
        for (int x = 5; x < 30; ++x)
            for (int c = 0; c < 3; ++c) ASSERT_EQ(part->Get({x - 5, y - 7}, c), all->Get({x, y}, c));
}

TEST(Render, SampleRangesAreDifferentSamples) {
    const std::string text = Everything("\"independent\" \"integer pixelsamples\" 4");
    const RenderSetup a = BuildText(text), b = BuildText(text);
    RenderOptions options;
    options.endSample = 4;
    RenderAll(a, options);
    options.firstSample = 4;
    options.endSample = 8;
    RenderAll(b, options);
    EXPECT_FALSE(SameBits(*a.film->Develop(), *b.film->Develop()));
}

TEST(Render, SeedsChangeTheNoise) {
    const auto a = test::RenderText(Everything("\"sobol\" \"integer pixelsamples\" 2"));
    const auto b = test::RenderText(Everything("\"sobol\" \"integer pixelsamples\" 2 \"integer seed\" 9"));
    EXPECT_FALSE(SameBits(*a, *b));

    const auto generatorSeed = [](const std::string& seed) {
        return BuildText(Everything("\"independent\" " + seed)).generatorSeed;
    };
    EXPECT_EQ(generatorSeed(""), 0);
    EXPECT_NE(generatorSeed("\"integer seed\" 8"), generatorSeed("\"integer seed\" 9"));
}

/// Keeps both cores of a small machine busy while it lives.
class Load {
  public:
    Load() {
        for (int i = 0; i < 2; ++i)
            threads_.emplace_back([this] {
                while (!stop_) count_ = count_ + 1;
            });
    }
    ~Load() {
        stop_ = true;
        for (std::thread& thread : threads_) thread.join();
    }

  private:
    std::atomic<bool> stop_ = false;
    std::atomic<int64_t> count_ = 0;
    std::vector<std::thread> threads_;
};

TEST(Render, TimeLimitsAreMetAlsoWhereLoadComesAndGoes) {
    for (const bool isLoaded : {false, true}) {
        const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 100000"));
        std::unique_ptr<Load> load;
        RenderOptions options;
        options.timeLimit = 0.5;
        options.afterPass = [&](int samples, double) {
            if (isLoaded && samples >= 8 && !load) load = std::make_unique<Load>();
        };
        const RenderStats stats = RenderAll(setup, options);
        EXPECT_TRUE(stats.timedOut);
        EXPECT_FALSE(stats.interrupted);
        EXPECT_NEAR(stats.seconds, 0.5, 0.2);
        EXPECT_GE(stats.samplesPerPixel, 1);
    }
    // However short it is, there is one sample a pixel.
    const RenderSetup hurry = BuildText(Everything("\"independent\" \"integer pixelsamples\" 100"));
    RenderOptions options;
    options.timeLimit = 0;
    EXPECT_EQ(RenderAll(hurry, options).samplesPerPixel, 1);
    EXPECT_GT(test::PixelLuminance(*hurry.film->Develop()).Mean(), 0.05);
}

TEST(Render, TimeLimitsKeepToGoodCountsWhereAskedTo) {
    for (const double limit : {0.003, 0.01, 0.02, 0.03, 0.05}) {
        const RenderSetup setup = BuildText(Everything("\"zsobol\" \"integer pixelsamples\" 65536"));
        RenderOptions options;
        options.timeLimit = limit;
        options.stopsAtGoodCounts = true;
        const RenderStats stats = RenderAll(setup, options);
        EXPECT_TRUE(stats.timedOut);
        if (stats.samplesPerPixel >= kFreeCounts) continue;
        EXPECT_TRUE((std::set<int>{1, 2, 4, 8, 12, 16, 24, 32, 48}.contains(stats.samplesPerPixel)))
            << stats.samplesPerPixel;
        EXPECT_EQ(stats.maxSamples, stats.samplesPerPixel);
    }
}

TEST(Render, TimeBetweenPassesDoesNotCount) {
    const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 4"));
    RenderOptions options;
    options.timeLimit = 30;
    options.afterPass = [](int, double) { std::this_thread::sleep_for(std::chrono::milliseconds(400)); };
    const RenderStats stats = RenderAll(setup, options);  // passes to 1, 2 and 4
    EXPECT_EQ(stats.samplesPerPixel, 4);
    EXPECT_LT(stats.seconds, 1);
}

// The value of a pixel is the mean of as many of its samples as the film says, whenever the limit comes: then
// it is unbiased, since the number of samples does not follow from their values.
TEST(Render, PixelsOfATimedRenderAreMeansOfTheSamplesTheyGot) {
    const std::string text = Everything("\"independent\" \"integer pixelsamples\" 100000");
    int uneven = 0;
    for (const double limit : {0.011, 0.017, 0.023, 0.031}) {
        const RenderSetup timed = BuildText(text);
        RenderOptions options;
        options.timeLimit = limit;
        const RenderStats stats = RenderAll(timed, options);
        const auto image = timed.film->Develop();
        int64_t total = 0;
        std::map<int, std::unique_ptr<Image>> byCount;
        for (int y = 0; y < 23; ++y)
            for (int x = 0; x < 37; ++x) {
                const int count = timed.film->SampleCount({x, y});
                total += count;
                EXPECT_GE(count, stats.samplesPerPixel);
                EXPECT_LE(count, stats.maxSamples);
                if (!byCount.contains(count)) {
                    const RenderSetup counted = BuildText(text);
                    RenderOptions all;
                    all.endSample = count;
                    RenderAll(counted, all);
                    byCount[count] = counted.film->Develop();
                }
                for (int c = 0; c < 3; ++c)
                    ASSERT_EQ(image->Get({x, y}, c), byCount[count]->Get({x, y}, c)) << x << " " << y;
            }
        EXPECT_EQ(total, stats.samples);
        EXPECT_LE(byCount.size(), 2u);
        uneven += byCount.size() == 2;
    }
    EXPECT_GE(uneven, 1) << "no limit fell within a pass: nothing was tested";
}

// Room for more samples than an int holds must not wrap around.
TEST(Render, HugeTimeLimitsAreNoLimits) {
    for (const double limit : {86400.0, 1e9, 1e300}) {
        const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 20"));
        RenderOptions options;
        options.timeLimit = limit;
        const RenderStats stats = RenderAll(setup, options);
        EXPECT_EQ(stats.samplesPerPixel, 20);
        EXPECT_FALSE(stats.timedOut || stats.interrupted);
    }
}

TEST(Render, PassesGrowAndEveryOneLeavesAWholeImage) {
    const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 200"));
    for (const double timeLimit : {double(Infinity), 1000.0}) {
        std::vector<int> done = {0};
        RenderOptions options;
        options.timeLimit = timeLimit;
        options.afterPass = [&](int samples, double) { done.push_back(samples); };
        const RenderStats stats = RenderAll(setup, options);
        // A first look soon, then at most fourfold and at most 64 samples more each time.
        EXPECT_LE(done[1], std::isfinite(timeLimit) ? 1 : 8);
        for (size_t i = 2; i < done.size(); ++i) {
            EXPECT_GT(done[i], done[i - 1]);
            EXPECT_LE(done[i], std::min(4 * done[i - 1], done[i - 1] + 64));
        }
        EXPECT_EQ(done.back(), 200);
        EXPECT_EQ(stats.samplesPerPixel, 200);
        EXPECT_FALSE(stats.timedOut || stats.interrupted);
        EXPECT_GT(stats.raysTraced, stats.cameraRays);
        EXPECT_GT(stats.shadowRays, 0);
    }
}

/// Asks to stop after some work and adds up what it is told.
class Impatient final : public Observer {
  public:
    void Begin(const std::string&, int64_t total, const std::string&) override { announced = total; }
    void Advance(int64_t units) override { done += units; }
    bool ShouldStop() override { return done > 5000; }
    int64_t announced = 0;
    std::atomic<int64_t> done = 0;
};

TEST(Render, StopsWhenTheObserverAsksForIt) {
    const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 4096"));
    Impatient observer;
    RenderOptions options;
    options.endSample = 4096;
    const RenderStats stats =
        Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, observer);
    EXPECT_EQ(observer.announced, int64_t(4096) * 37 * 23);
    EXPECT_TRUE(stats.interrupted);
    EXPECT_FALSE(stats.timedOut);
    EXPECT_LT(stats.samplesPerPixel, 4096);
}

TEST(Halves, TakeLongRunsOfSamplesAndAreEven) {
    for (const auto& [count, block] :
         std::map<int, int>{{64, 32}, {8, 4}, {12, 2}, {2, 1}, {7, 1}, {1, 1}, {0, 1}}) {
        EXPECT_EQ(HalfBlockOf(count), block) << count;
        int first = 0;
        for (int i = 0; i < count; ++i) first += Halves{block}.IsFirst(i);
        EXPECT_EQ(first, (count + 1) / 2) << count;
    }
}

/// Of a render that was stopped, the file says how many samples each half has.
TEST(Halves, CountTheirSamples) {
    const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 8"));
    const auto aovs = MakeAovBuffer({"half"}, 6, setup);
    const auto countAfter = [&](int first, int end) {
        RenderOptions options;
        options.aovs = aovs.get();
        options.firstSample = first;
        options.endSample = end;
        RenderAll(setup, options);
        const auto image = DevelopRender(setup, aovs.get(), nullptr, {});
        return image->Get({3, 4}, image->FindChannel("Half.samples"));
    };
    EXPECT_EQ(countAfter(0, 8), 4);
    // 12 samples by now, and in blocks of 2 the last 4 are halved.
    EXPECT_EQ(countAfter(0, 4), 6);
}

TEST(Render, WithoutJitterPixelsAreTheirCenters) {
    // A sharp edge through the middle of pixel column 2: centres are on its lit side, in every sample.
    const RenderSetup setup = BuildText(
        "Camera \"orthographic\" \"float screenwindow\" [0 4 0 1] Film \"rgb\" \"integer xresolution\" 4 "
        "\"integer yresolution\" 1 "
        "PixelFilter \"box\" Sampler \"independent\" \"integer pixelsamples\" 8 WorldBegin AreaLightSource "
        "\"diffuse\" "
        "\"bool twosided\" true Shape \"bilinearmesh\" \"point3 P\" [2.4 -1 1  9 -1 1  2.4 2 1  9 2 1]");
    RenderOptions options;
    options.jitter = {false, false};
    RenderAll(setup, options);
    const auto image = setup.film->Develop();
    EXPECT_EQ(image->Get({1, 0}, 1), 0);
    EXPECT_GT(image->Get({2, 0}, 1), 0.1f);
    EXPECT_EQ(image->Get({2, 0}, 1), image->Get({3, 0}, 1));
}

TEST(Render, PixelStatsAddUpToTheCounters) {
    const RenderSetup setup = BuildText(Everything("\"independent\" \"integer pixelsamples\" 40"));
    PixelStats costs(setup.film->PixelBounds());
    RenderOptions options;
    options.pixelStats = &costs;
    const RenderStats stats = RenderAll(setup, options);
    const auto image = costs.Develop(setup.film->Resolution());
    EXPECT_EQ(image->Resolution(), Int2(37, 23));
    double sums[4] = {0, 0, 0, 0};
    for (int y = 0; y < 23; ++y)
        for (int x = 0; x < 37; ++x)
            for (int c = 0; c < 4; ++c) {
                const float value = image->Get({x, y}, c);
                EXPECT_TRUE(value > 0 || c > 1) << image->Channels()[size_t(c)];
                sums[c] += double(value);
            }
    EXPECT_EQ(sums[1], double(stats.raysTraced));
    EXPECT_EQ(sums[2], double(stats.shadowRays));
    EXPECT_EQ(sums[3], double(stats.pathLengthSum));
    // No thread is in two pixels at once.
    EXPECT_LE(sums[0], stats.seconds * stats.threads);
}

}  // namespace
}  // namespace lacquer::render_test
