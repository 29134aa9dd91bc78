// Splats: where they land, what they weigh, and that threads do not matter.
#include <gtest/gtest.h>

#include "pbrt/base/film.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/splats.h"
#include "pbrt/image/image.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::splats_test {
namespace {

using test::FullTestName;
using test::SeedOf;

std::unique_ptr<Film> MakeFilm(const std::string& filter, const std::string& extra = "",
                               const std::string& filterText = "") {
    const Params params =
        test::ParamsFromText("film", "\"integer xresolution\" 12 \"integer yresolution\" 9 " + extra);
    const Params filterParams = test::ParamsFromText("filter", filterText);
    auto film = Registry<FilmKind>::Find("rgb")(
        {params, FilmOverrides(), Registry<FilterKind>::Find(filter)(filterParams), 1.f});
    film->PrepareForSplats(MaxThreads());
    return film;
}
const SampledWavelengths kLambda = SampledWavelengths::SampleVisible(0.3f);

/// One camera sample in every pixel, which sees nothing.
void AddBlackSamples(Film& film) {
    const Bounds2i b = film.PixelBounds();
    for (int y = b.min.y; y < b.max.y; ++y)
        for (int x = b.min.x; x < b.max.x; ++x) film.AddSample({x, y}, SampledSpectrum(0), kLambda, 1);
}
double Sum(const Image& image) {
    double sum = 0;
    for (const float x : image.Pixels()) sum += double(x);
    return sum;
}
/// What a camera sample of the same radiance makes of a pixel, all channels together.
double PixelOf(float L) {
    const auto film = MakeFilm("box");
    AddBlackSamples(*film);
    auto one = MakeFilm("box");
    one->AddSample({0, 0}, SampledSpectrum(L), kLambda, 1);
    return Sum(*one->Develop());
}

// The film's 108 pixels got 108 paths: a splat of L adds what L in one pixel does, wherever it lands.
TEST(Splats, ASplatAddsItsLightOnce) {
    const double expected = PixelOf(2);
    for (const std::string filter : {"box", "gaussian", "triangle", "mitchell"}) {
        const auto film = MakeFilm(filter);
        AddBlackSamples(*film);
        Rng rng(SeedOf(filter));
        const int count = 200;
        for (int i = 0; i < count; ++i)
            EXPECT_TRUE(
                film->AddSplat({4.5f + 3 * rng.Uniform(), 4 + rng.Uniform()}, SampledSpectrum(2), kLambda));
        // Sums of the filter over a grid of unit cells scatter about its integral: by 7 % for this Gaussian.
        EXPECT_NEAR(Sum(*film->Develop()) / count / expected, 1, 0.02) << filter;
    }
}

TEST(Splats, LandByTheFilterAboutPixelCentres) {
    const auto film = MakeFilm("triangle", "", "\"float xradius\" 1.25 \"float yradius\" 1");
    AddBlackSamples(*film);
    film->AddSplat({5.75f, 3.5f}, SampledSpectrum(2), kLambda);
    const auto image = film->Develop();
    // Centres at 4.5 (1.25 away: the end), 5.5 and 6.5: weights (1.25 - |x|) over the integral 1.25^2.
    const double unit = PixelOf(2) / (1.25 * 1.25);
    const auto at = [&](int x, int y) {
        return double(image->Get({x, y}, 0)) + double(image->Get({x, y}, 1)) + double(image->Get({x, y}, 2));
    };
    EXPECT_NEAR(at(5, 3), unit * 1.0, 1e-4 * unit);
    EXPECT_NEAR(at(6, 3), unit * 0.5, 1e-4 * unit);
    EXPECT_NEAR(at(4, 3), 0, 1e-9 * unit);
    EXPECT_NEAR(Sum(*image), unit * 1.5, 1e-4 * unit);
}

// A film of a part of the image gets fewer paths, and each of them stands for more.
TEST(Splats, PartsOfTheImageShowWhatTheWholeShows) {
    const auto whole = MakeFilm("gaussian");
    const auto part = MakeFilm("gaussian", "\"integer pixelbounds\" [3 9 2 7]");
    for (const auto& film : {&whole, &part}) AddBlackSamples(**film);
    // 108 paths splat twice at one point; so 30 paths do 30/108 of that.
    for (int i = 0; i < 108; ++i) whole->AddSplat({3.2f, 4.4f}, SampledSpectrum(2), kLambda);
    for (int i = 0; i < 30; ++i) part->AddSplat({3.2f, 4.4f}, SampledSpectrum(2), kLambda);
    const auto a = whole->Develop(), b = part->Develop();
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(a->Get({3, 4}, c), b->Get({0, 2}, c), 1e-5f * std::abs(a->Get({3, 4}, c)));
    EXPECT_TRUE(part->IsInSplatRange({2.1f, 4}));
    EXPECT_FALSE(part->IsInSplatRange({1.9f, 4}));
    EXPECT_FALSE(part->IsInSplatRange({5, 8.1f}));
}

TEST(Splats, CountLikeSamplesWhereTheyAreBad) {
    const auto film = MakeFilm("box");
    AddBlackSamples(*film);
    EXPECT_FALSE(film->AddSplat({1, 1}, SampledSpectrum(NAN), kLambda));
    EXPECT_FALSE(film->AddSplat({1, 1}, SampledSpectrum(-1), kLambda));
    EXPECT_FALSE(film->AddSplat({NAN, 1}, SampledSpectrum(1), kLambda));
    EXPECT_TRUE(film->AddSplat({-1000, 1e9f}, SampledSpectrum(1), kLambda));
    EXPECT_EQ(Sum(*film->Develop()), 0);
}

TEST(Splats, ObeyTheLimitOfComponents) {
    const auto film = MakeFilm("box", "\"float maxcomponentvalue\" 1");
    AddBlackSamples(*film);
    film->AddSplat({1.5f, 1.5f}, SampledSpectrum(1e6f), kLambda);
    EXPECT_LT(Sum(*film->Develop()), 108 * 4.);
}

/// 20000 splats of sizes from 1e-6 to 1e6, by several threads.
std::unique_ptr<Image> ManySplats(int threads) {
    const ThreadLimit limit(threads);
    const auto film = MakeFilm("gaussian");
    AddBlackSamples(*film);
    ParallelFor(20000, [&](int64_t i) {
        Rng rng(Hash(i));
        const Point2 p(12 * rng.Uniform(), 9 * rng.Uniform());
        film->AddSplat(p, SampledSpectrum(std::pow(10.f, 12 * rng.Uniform() - 6)), kLambda);
    });
    return film->Develop();
}
TEST(Splats, DoNotDependOnThreads) {
    const auto one = ManySplats(1);
    for (const int threads : {2, 5, 8}) {
        const auto many = ManySplats(threads);
        for (size_t i = 0; i < one->Pixels().size(); ++i)
            ASSERT_EQ(one->Pixels()[i], many->Pixels()[i]) << threads;
    }
}
TEST(Splats, NegativeControlFloatsDependOnTheirOrder) {
    double forward = 0, backward = 0;
    const auto term = [](int i) { return std::pow(10., 12 * double(Rng(Hash(i)).Uniform()) - 6); };
    for (int i = 0; i < 2000; ++i) forward += term(i);
    for (int i = 2000; i-- > 0;) backward += term(i);
    EXPECT_NE(forward, backward);
}

// The whole part of such a sum takes more than 64 bits.
TEST(Splats, HugeSumsKeepTheirSign) {
    const auto filter = Registry<FilterKind>::Find("box")(test::ParamsFromText("filter", ""));
    SplatSums sums;
    sums.Prepare({Int2(0), Int2(1)}, MaxThreads());
    constexpr int kCount = 200000;
    for (int i = 0; i < kCount; ++i) sums.Add({0.5f, 0.5f}, Vec3(1e14f, -1e14f, 0.25f), *filter);
    EXPECT_NEAR(sums.Sum(0).x / (kCount * double(1e14f)), 1, 1e-6);
    EXPECT_NEAR(sums.Sum(0).y / (kCount * double(1e14f)), -1, 1e-6);
    EXPECT_EQ(sums.Sum(0).z, 0.25 * kCount);
}

TEST(Splats, AFilmWithoutThemSaysWhatItHolds) {
    SplatSums sums;
    EXPECT_EQ(sums.Bytes(), 0u);
    sums.Prepare({Int2(0), Int2(4, 4)}, MaxThreads());
    EXPECT_EQ(sums.Bytes(), 0u);  // nothing was splatted yet
    EXPECT_THROW(SplatSums().Prepare({Int2(0), Int2(1 << 15, 1 << 10)}, 1000), OverrideError);
}

}  // namespace
}  // namespace lacquer::splats_test
