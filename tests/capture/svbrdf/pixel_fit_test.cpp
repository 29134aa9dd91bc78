// Fits of photographs that the model itself has made.
#include "capture/svbrdf/pixel_fit.h"

#include <gtest/gtest.h>

#include <limits>

#include "capture/svbrdf/made_maps.h"
#include "pbrt/core/parallel.h"
#include "support/stopping_observer.h"

namespace lacquer::capture::pixel_fit_test {
namespace {

using test::GridViews;
using test::MadeMaps;
using test::NovelRmse;
using test::Pattern;
using test::RandomMaps;
using test::RenderViews;

constexpr int kSize = 32;
constexpr Pattern kPatterns[] = {Pattern::Patches, Pattern::Tiles, Pattern::Waves};

FitSettings Quick(int iterations, double totalVariation) {
    FitSettings settings;
    settings.iterations = iterations;
    settings.totalVariation = totalVariation;
    return settings;
}

/// Means over the patterns, of fits from nothing.
struct Errors {
    double input = 0, novel = 0;
};
Errors FitPatterns(int numViews, const FitSettings& settings) {
    Errors mean;
    for (const Pattern pattern : kPatterns) {
        const ViewSet views = GridViews(numViews);
        const Maps truth = MadeMaps(kSize, pattern, 1);
        const FitResult fit = FitFromConstant(views, RenderViews(truth, views), {}, settings);
        EXPECT_EQ(fit.end, FitResult::End::Finished);
        mean.input += fit.inputRmse.back() / 3;
        mean.novel += NovelRmse(fit.maps, truth, views) / 3;
    }
    return mean;
}

// What fits from a grey plate begin with is an error of 0.15 and more.
TEST(PixelFit, FindsAgainWhatItShowed) {
    const Errors errors = FitPatterns(9, Quick(300, 0.003));
    EXPECT_LT(errors.input, 0.01);
    EXPECT_LT(errors.novel, 0.03);
}

TEST(PixelFit, TotalVariationHelpsThreePhotographs) {
    const Errors without = FitPatterns(3, Quick(250, 0)), with = FitPatterns(3, Quick(250, 0.003));
    EXPECT_LT(with.novel, 0.85 * without.novel);
    EXPECT_LT(with.novel, 0.06);
}

/// Error of what is shown to the camera by a fit of three photographs under other assumptions than they were
/// made.
double InputRmseOf(const ViewSet& assumed, const std::vector<RectifiedImage>& images) {
    return FitFromConstant(assumed, images, {}, Quick(200, 0)).inputRmse.back();
}

TEST(PixelFit, WrongAssumptionsShow) {
    const ViewSet views = GridViews(9);
    const auto images = RenderViews(MadeMaps(kSize, Pattern::Patches, 2), views);
    const double right = InputRmseOf(views, images);
    ViewSet swapped = views;
    std::swap(swapped.views[0], swapped.views[5]);
    EXPECT_GT(InputRmseOf(swapped, images), 3 * right);
    // A brighter light with a darker sample is nearly the same; half of the light is not: nothing is whiter
    // than white.
    ViewSet dark = views;
    for (double& power : dark.lightPower) power *= 0.25;
    EXPECT_GT(InputRmseOf(dark, images), 3 * right);
}

// It finds it roughly: steep normals and less of a lobe take up some of what is too bright.
TEST(PixelFit, FindsThePowerOfTheLightByWhatIsWhite) {
    const ViewSet views = GridViews(5);
    Maps truth = MadeMaps(16, Pattern::Waves, 3);
    for (size_t c = 0; c < 3; ++c)
        for (double& value : truth.Channel(kAlbedo + c)) value = 1;
    const auto images = RenderViews(truth, views);
    ViewSet assumed = views;
    for (double& power : assumed.lightPower) power *= 0.4;
    FitSettings settings = Quick(400, 0.003);
    const double without = FitFromConstant(assumed, images, {}, settings).inputRmse.back();
    settings.fitLightPower = true;
    const FitResult fit = FitFromConstant(assumed, images, {}, settings);
    EXPECT_LT(fit.inputRmse.back(), 0.3 * without);
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(fit.lightPower[c], views.lightPower[c], 0.3 * views.lightPower[c]);
}

TEST(PixelFit, LeavesOutWhatIsForTests) {
    ViewSet views = GridViews(5);
    auto images = RenderViews(MadeMaps(16, Pattern::Tiles, 4), views);
    views.views[3].isTest = true;
    const FitResult with = FitMaps(views, images, ConstantMaps(16), Quick(5, 0));
    images[3] = RectifiedImage(16);
    EXPECT_EQ(FitMaps(views, images, ConstantMaps(16), Quick(5, 0)).maps.values, with.maps.values);
}

TEST(PixelFit, BitsDoNotDependOnThreads) {
    const ViewSet views = GridViews(3);
    const Maps truth = MadeMaps(22, Pattern::Tiles, 2);  // no whole number of lanes
    const auto images = RenderViews(truth, views);
    std::vector<FitResult> results;
    for (const int threads : {1, 2}) {
        const ThreadLimit limit(threads);
        FitSettings settings = Quick(40, 0.003);
        settings.fitLightPower = true;
        results.push_back(FitFromConstant(views, images, {}, settings));
    }
    EXPECT_EQ(results[0].maps.values, results[1].maps.values);
    EXPECT_EQ(results[0].inputRmse, results[1].inputRmse);
    EXPECT_EQ(results[0].lightPower, results[1].lightPower);
}

// The last lanes of a row have no texels: what they hold must not matter.
TEST(PixelFit, SizesNeedNotBeWholeLanes) {
    const ViewSet views = GridViews(3);
    const Maps truth = MadeMaps(13, Pattern::Waves, 5);
    const FitResult fit = FitMaps(views, RenderViews(truth, views), truth, Quick(1, 0));
    EXPECT_LT(fit.inputRmse[0], 1e-5);
    const FitResult one =
        FitMaps(views, RenderViews(ConstantMaps(1), views), ConstantMaps(1), Quick(20, 0.003));
    EXPECT_LT(one.inputRmse.back(), 0.01);
}

TEST(PixelFit, StopsAndTellsEachStep) {
    const ViewSet views = GridViews(1);
    const auto images = RenderViews(ConstantMaps(16), views);
    lacquer::test::StoppingObserver observer(30);
    std::vector<int> steps;
    FitSettings settings = Quick(40, 0);  // 20 of half the size come first
    settings.afterStep = [&](const FitStep& step) { steps.push_back(step.iteration); };
    const FitResult fit = FitFromConstant(views, images, {}, settings, &observer);
    EXPECT_EQ(fit.end, FitResult::End::Stopped);
    ASSERT_EQ(fit.inputRmse.size(), 30U);
    ASSERT_EQ(steps.size(), 30U);
    for (int i = 0; i < 30; ++i) EXPECT_EQ(steps[size_t(i)], i);
    EXPECT_EQ(fit.maps.size, 16);
}

TEST(PixelFit, KeepsTheLastMapsOfALossThatIsANumber) {
    const ViewSet views = GridViews(3);
    const Maps start = MadeMaps(16, Pattern::Patches, 6);
    auto images = RenderViews(ConstantMaps(16), views);
    FitSettings settings = Quick(50, 0);
    settings.learningRate = std::numeric_limits<double>::quiet_NaN();
    settings.fitLightPower = true;
    const FitResult second = FitMaps(views, images, start, settings);
    EXPECT_EQ(second.inputRmse.size(), 1U);
    images[1].values[77] = std::numeric_limits<double>::quiet_NaN();
    const FitResult first = FitMaps(views, images, start, Quick(50, 0));
    EXPECT_EQ(first.inputRmse.size(), 0U);
    for (const FitResult& fit : {first, second}) {
        EXPECT_EQ(fit.end, FitResult::End::NotFinite);
        EXPECT_EQ(fit.lightPower, views.lightPower);
        for (size_t i = 0; i < start.values.size(); ++i)
            ASSERT_NEAR(fit.maps.values[i], start.values[i], 1e-7);
    }
}

TEST(PixelFit, RefusesWhatDoesNotMatch) {
    ViewSet views = GridViews(3);
    const auto images = RenderViews(ConstantMaps(16), views);
    EXPECT_THROW(FitMaps(views, images, ConstantMaps(8), {}), std::invalid_argument);
    EXPECT_THROW(FitFromConstant(views, std::span(images).first(2), {}, {}), std::invalid_argument);
    for (View& view : views.views) view.isTest = true;
    EXPECT_THROW(FitFromConstant(views, images, {}, {}), std::invalid_argument);
}

TEST(PixelFit, ResizedMapsShowTheSame) {
    const ViewSet views = GridViews(3);
    const Maps fine = MadeMaps(64, Pattern::Waves, 7), coarse = MadeMaps(32, Pattern::Waves, 7);
    const auto rmse = [](const Maps& a, const Maps& b) {
        double sum = 0;
        for (size_t i = 0; i < a.values.size(); ++i)
            sum += (a.values[i] - b.values[i]) * (a.values[i] - b.values[i]);
        return std::sqrt(sum / double(a.values.size()));
    };
    EXPECT_LT(rmse(ResizeMaps(coarse, 64), fine), 0.015);
    EXPECT_LT(rmse(ResizeMaps(fine, 32), coarse), 0.015);
    EXPECT_LT(rmse(ResizeMaps(ConstantMaps(8), 21), ConstantMaps(21)), 1e-14);
    EXPECT_GT(rmse(ResizeMaps(ConstantMaps(32), 64), fine), 0.1);
}

// What the fit makes small, by its definition: the photographs are those of the maps, so all that is left is
// one edge, along which a channel changes by a half.
TEST(FitObjective, IsThePhotographsAndTheVariation) {
    const ViewSet views = GridViews(3);
    Maps maps(16);
    for (size_t row = 0; row < 16; ++row)
        for (size_t column = 8; column < 16; ++column) maps.Channel(kRoughness)[16 * row + column] = 0.5;
    const std::vector<RectifiedImage> images = RenderViews(maps, views);
    // Roughness counts three times; below a difference of 0.01 by the square.
    const double edge = 3 * 16 * (0.5 - 0.005) / (9. * 16 * 16);
    EXPECT_NEAR(FitObjective(views, images, maps, 0), 0, 1e-12);
    EXPECT_NEAR(FitObjective(views, images, maps, 0.25), 0.25 * edge, 1e-6);
    EXPECT_GT(FitObjective(views, images, MadeMaps(16, Pattern::Waves, 1), 0), 1e-4);
}

struct BothWays {
    ViewSet views;
    std::vector<RectifiedImage> images;
    FitResult coarse, oneSize, taken;
    std::vector<double> told;
    double Objective(const FitResult& fit, double variation) const {
        return FitObjective(views, images, fit.maps, variation);
    }
};
BothWays FitBothWays(const Maps& truth, int numViews) {
    BothWays both{GridViews(numViews), {}, {}, {}, {}, {}};
    both.images = RenderViews(truth, both.views);
    FitSettings settings = Quick(200, 0.003);
    both.coarse = FitFromConstant(both.views, both.images, {}, settings);
    both.oneSize = FitMaps(both.views, both.images, ConstantMaps(truth.size), settings);
    settings.afterStep = [&](const FitStep& step) {
        EXPECT_EQ(size_t(step.iteration), both.told.size());
        both.told.push_back(step.inputRmse);
    };
    both.taken = FitTexels(both.views, both.images, {}, settings);
    EXPECT_EQ(both.taken.inputRmse, both.told);
    return both;
}

TEST(FitTexels, GoesFromCoarseToFineWhereLargePartsAreAlike) {
    const Maps truth = MadeMaps(kSize, Pattern::Waves, 1);
    const BothWays both = FitBothWays(truth, 3);
    EXPECT_LT(both.Objective(both.coarse, 0.003), both.Objective(both.oneSize, 0.003));
    EXPECT_EQ(both.taken.maps.values, both.coarse.maps.values);
    EXPECT_TRUE(both.taken.isCoarseToFine);
    EXPECT_LT(NovelRmse(both.coarse.maps, truth, both.views),
              NovelRmse(both.oneSize.maps, truth, both.views));
}

TEST(FitTexels, StaysAtOneSizeWhereTexelsDiffer) {
    const Maps truth = RandomMaps(kSize, 1);
    const BothWays both = FitBothWays(truth, 3);
    EXPECT_LT(both.Objective(both.oneSize, 0.003), both.Objective(both.coarse, 0.003));
    EXPECT_EQ(both.taken.maps.values, both.oneSize.maps.values);
    EXPECT_FALSE(both.taken.isCoarseToFine);
    EXPECT_LT(NovelRmse(both.oneSize.maps, truth, both.views),
              NovelRmse(both.coarse.maps, truth, both.views));
}

TEST(FitTexels, StaysAtOneSizeWithOnePhotograph) {
    for (const Pattern pattern : kPatterns) {
        const BothWays both = FitBothWays(MadeMaps(kSize, pattern, 1), 1);
        EXPECT_EQ(both.taken.maps.values, both.oneSize.maps.values);
    }
}

TEST(FitTexels, StopsInEitherFit) {
    const ViewSet views = GridViews(3);
    const std::vector<RectifiedImage> images = RenderViews(MadeMaps(16, Pattern::Waves, 1), views);
    for (const int after : {5, 25}) {
        lacquer::test::StoppingObserver observer(after);
        int told = 0;
        FitSettings settings = Quick(20, 0);
        settings.afterStep = [&](const FitStep&) { ++told; };
        const FitResult fit = FitTexels(views, images, {}, settings, &observer);
        EXPECT_EQ(fit.end, FitResult::End::Stopped);
        EXPECT_EQ(fit.isCoarseToFine, after > 20);
        EXPECT_EQ(size_t(told), fit.inputRmse.size());
    }
}

}  // namespace
}  // namespace lacquer::capture::pixel_fit_test
