#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "pbrt/base/sampler.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::samplers_test {
namespace {

struct Setting {
    std::string name, randomization;  ///< the latter may be empty
    std::string Name() const { return name + (randomization.empty() ? "" : "_" + randomization); }
};

const std::vector<Setting> kSettings = {
    {"independent", ""},         {"stratified", ""},          {"halton", "none"},
    {"halton", "owen"},          {"halton", "permutedigits"}, {"sobol", "none"},
    {"sobol", "owen"},           {"sobol", "permutedigits"},  {"sobol", "fastowen"},
    {"paddedsobol", "none"},     {"paddedsobol", "owen"},     {"paddedsobol", "permutedigits"},
    {"zsobol", "none"},          {"zsobol", "owen"},          {"zsobol", "permutedigits"},
    {"paddedsobol", "fastowen"}, {"zsobol", "fastowen"},      {"pmj02bn", ""}};

/// Kinds made of two-dimensional Sobol sequences.
bool IsBinary(const Setting& setting) {
    return setting.name == "sobol" || setting.name == "paddedsobol" || setting.name == "zsobol" ||
           setting.name == "pmj02bn";
}

Parameter Integer(const std::string& name, int value) {
    Parameter p;
    p.type = "integer";
    p.name = name;
    p.kind = Parameter::Values::Integers;
    p.integers = {value};
    return p;
}

Parameter String(const std::string& name, const std::string& value) {
    Parameter p;
    p.type = "string";
    p.name = name;
    p.kind = Parameter::Values::Strings;
    p.strings = {value};
    return p;
}

std::unique_ptr<Sampler> Make(const std::string& name, const std::vector<Parameter>& parameters,
                              std::optional<int> override = std::nullopt, Int2 resolution = {16, 16},
                              int seed = 0) {
    const Params params("sampler \"" + name + "\"", {"scene.pbrt", 2, 1}, parameters, nullptr);
    auto sampler = Registry<SamplerKind>::Find(name)({params, resolution, override, seed});
    params.CheckAllUsed();
    return sampler;
}

std::unique_ptr<Sampler> Make(const Setting& setting, int samples, Int2 resolution = {16, 16}, int seed = 0) {
    std::vector<Parameter> parameters;
    if (!setting.randomization.empty()) parameters.push_back(String("randomization", setting.randomization));
    return Make(setting.name, parameters, samples, resolution, seed);
}

/// One sample's values along a mixture of one- and two-dimensional requests.
std::vector<float> Values(Sampler& sampler, Int2 pixel, int index, int count) {
    sampler.StartPixelSample(pixel, index);
    const Point2 p = sampler.GetPixel2D();
    std::vector<float> values = {p.x, p.y};
    for (int i = 0; int(values.size()) < count; ++i) {
        if (i % 3 == 1) {
            values.push_back(sampler.Get1D());
        } else {
            const Point2 q = sampler.Get2D();
            values.push_back(q.x);
            values.push_back(q.y);
        }
    }
    return values;
}

TEST(Samplers, ValuesLieInTheUnitInterval) {
    // Also far beyond the last dimension, the resolution and the sample count.
    for (const Setting& setting : kSettings) {
        const auto sampler = Make(setting, 19, {40, 30}, 5);
        for (const Int2 pixel : {Int2(0, 0), Int2(39, 29), Int2(-3, -1), Int2(2000000000, 2000000000)})
            for (const int index : {0, 1, 18, 100, (1 << 24) - 1})
                for (const float value : Values(*sampler, pixel, index, 400))
                    ASSERT_TRUE(value >= 0 && value < 1) << setting.Name() << ' ' << value;
    }
}

TEST(Samplers, ValuesDependOnNothingButSeedPixelIndexAndDimension) {
    const int numPixels = 6, numIndices = 20, count = 150;
    const auto pixelOf = [](int i) { return Int2(i * 5 % 16, i * 3 % 16); };
    for (const Setting& setting : kSettings) {
        // In order, each pixel by itself.
        std::vector<std::vector<float>> reference;
        const auto first = Make(setting, 20);
        for (int p = 0; p < numPixels; ++p)
            for (int i = 0; i < numIndices; ++i) reference.push_back(Values(*first, pixelOf(p), i, count));
        // In random order, on a used clone and on a new sampler, in turn.
        const auto clone = first->Clone(), second = Make(setting, 20);
        for (uint32_t k = 0; k < uint32_t(numPixels * numIndices); ++k) {
            const auto at = int(PermutationElement(k, uint32_t(numPixels * numIndices), 42));
            Sampler& sampler = k % 3 == 0 ? *first : k % 3 == 1 ? *clone : *second;
            // A different pattern of requests in between must leave no trace.
            sampler.StartPixelSample(pixelOf(at / numIndices), at % numIndices);
            for (int d = 0; d < 11; ++d) sampler.Get1D();
            ASSERT_EQ(Values(sampler, pixelOf(at / numIndices), at % numIndices, count),
                      reference[size_t(at)])
                << setting.Name();
        }
    }
}

TEST(Samplers, SkippedDimensionsLeaveOthersAsTheyAre) {
    for (const Setting& setting : kSettings) {
        const auto all = Make(setting, 20), some = Make(setting, 20);
        for (int index = 0; index < 20; ++index) {
            all->StartPixelSample({3, 4}, index);
            some->StartPixelSample({3, 4}, index);
            for (int d = 0; d < 100; ++d) {  // beyond the last dimension that the sampler stratifies
                EXPECT_EQ(some->Get2D(), all->Get2D()) << setting.Name() << ' ' << d;
                some->Skip1D();
                all->Get1D();
                some->Skip2D();
                all->Get2D();
                EXPECT_EQ(some->Get1D(), all->Get1D()) << setting.Name() << ' ' << d;
            }
        }
    }
}

TEST(Samplers, SeedsPixelsAndIndicesGiveOtherValues) {
    for (const Setting& setting : kSettings) {
        const auto a = Make(setting, 16), b = Make(setting, 16, {16, 16}, 1);
        const std::vector<float> values = Values(*a, {3, 4}, 5, 40);
        if (setting.randomization != "none") {
            EXPECT_NE(values, Values(*b, {3, 4}, 5, 40)) << setting.Name();
        }
        EXPECT_NE(values, Values(*a, {4, 3}, 5, 40)) << setting.Name();
        EXPECT_NE(values, Values(*a, {3, 4}, 6, 40)) << setting.Name();
    }
}

/// The 2D points of a pixel's samples: its positions, or those of a later pair of dimensions.
std::vector<Point2> PixelPoints(Sampler& sampler, Int2 pixel, int count, bool isPosition = true) {
    std::vector<Point2> points;
    for (int i = 0; i < count; ++i) {
        sampler.StartPixelSample(pixel, i);
        if (!isPosition) sampler.Get1D();
        points.push_back(isPosition ? sampler.GetPixel2D() : sampler.Get2D());
    }
    return points;
}

/// True if each of the nx * ny equal boxes has one point; `rounding` is added to values that are not exact
/// fractions.
bool OnePerBox(const std::vector<Point2>& points, int nx, int ny, double rounding = 0) {
    std::set<int> boxes;
    for (const Point2 p : points)
        boxes.insert(int(double(p.y) * ny + rounding) * nx + int(double(p.x) * nx + rounding));
    return boxes.size() == points.size() && int(points.size()) == nx * ny;
}

bool IsBinaryNet(const std::vector<Point2>& points) {
    for (int nx = 1; nx <= int(points.size()); nx *= 2)
        if (!OnePerBox(points, nx, int(points.size()) / nx)) return false;
    return true;
}

TEST(Samplers, SobolKindsPutOnePointIntoEveryElementaryInterval) {
    for (const Setting& setting : kSettings) {
        if (!IsBinary(setting)) continue;
        for (int count = 1; count <= 512; count *= 2) {
            const auto sampler = Make(setting, count);
            for (const Int2 pixel : {Int2(0, 0), Int2(7, 2), Int2(15, 15)}) {
                EXPECT_TRUE(IsBinaryNet(PixelPoints(*sampler, pixel, count)))
                    << setting.Name() << ' ' << count;
                if (setting.name == "sobol") continue;
                EXPECT_TRUE(IsBinaryNet(PixelPoints(*sampler, pixel, count, false)))
                    << setting.Name() << count;
            }
        }
    }
    // Negative control: 64 independent points are a net with a probability below 64! / 64^64 = 1e-27.
    EXPECT_FALSE(IsBinaryNet(PixelPoints(*Make(kSettings[0], 64), {0, 0}, 64)));
}

TEST(Samplers, GlobalSobolKindsAreNetsOverTheWholeImage) {
    // 8 x 8 pixels of 4 samples are 256 points of the unit square.
    for (const Setting& setting : kSettings) {
        if (setting.name != "sobol" && setting.name != "zsobol") continue;
        const auto sampler = Make(setting, 4, {8, 8});
        std::vector<Point2> points;
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x)
                for (const Point2 p : PixelPoints(*sampler, {x, y}, 4, setting.name == "sobol"))
                    points.push_back(setting.name == "sobol" ? (Point2(x, y) + p) / 8.f : p);
        EXPECT_TRUE(IsBinaryNet(points)) << setting.Name();
    }
}

TEST(Samplers, HaltonIsStratifiedInBasesTwoAndThree) {
    for (const Setting& setting : kSettings) {
        if (setting.name != "halton") continue;
        const auto sampler = Make(setting, 72, {200, 300}, 3);
        for (const Int2 pixel : {Int2(0, 0), Int2(127, 17), Int2(150, 299)})
            EXPECT_TRUE(OnePerBox(PixelPoints(*sampler, pixel, 72), 8, 9, 1e-4)) << setting.Name();
        // A tile of 8 x 9 pixels with 6 samples each: 16 x 27 boxes.
        const auto small = Make(setting, 6, {8, 9}, 4);
        std::vector<Point2> points;
        for (int y = 0; y < 9; ++y)
            for (int x = 0; x < 8; ++x)
                for (const Point2 p : PixelPoints(*small, {x, y}, 6))
                    points.push_back((Point2(x, y) + p) / Point2(8, 9));
        EXPECT_TRUE(OnePerBox(points, 16, 27, 1e-4)) << setting.Name();
    }
}

TEST(Samplers, StratifiedHasOnePointInEveryCell) {
    const auto sampler = Make("stratified", {Integer("xsamples", 3), Integer("ysamples", 5)});
    for (const Int2 pixel : {Int2(0, 0), Int2(9, 14)}) {
        EXPECT_TRUE(OnePerBox(PixelPoints(*sampler, pixel, 15), 3, 5));
        EXPECT_TRUE(OnePerBox(PixelPoints(*sampler, pixel, 15, false), 3, 5));
        std::set<int> cells;
        for (int i = 0; i < 15; ++i) {
            sampler->StartPixelSample(pixel, i);
            cells.insert(int(sampler->Get1D() * 15));
        }
        EXPECT_EQ(cells.size(), 15u);
    }
    // Without jitter the points are the centres of the cells.
    Parameter jitter;
    jitter.type = "bool";
    jitter.name = "jitter";
    jitter.kind = Parameter::Values::Bools;
    jitter.bools = {0};
    const auto regular = Make("stratified", {jitter});
    for (const Point2 p : PixelPoints(*regular, {1, 1}, 16)) {
        EXPECT_EQ(p.x * 4 - std::floor(p.x * 4), 0.5f);
        EXPECT_EQ(p.y * 4 - std::floor(p.y * 4), 0.5f);
    }
}

TEST(Samplers, MeansAreIntegrals) {
    // 64 pixels x 64 samples: the bound is five standard errors of independent samples; the others have
    // smaller ones.
    const int numPixels = 64, count = 64;
    const double n = numPixels * count;
    for (const Setting& setting : kSettings) {
        const auto sampler = Make(setting, count);
        double x[8] = {}, xy[8] = {}, board[8] = {};
        for (int p = 0; p < numPixels; ++p)
            for (int i = 0; i < count; ++i) {
                sampler->StartPixelSample({p % 8, p / 8}, i);
                for (int d = 0; d < 8; ++d) {
                    const Point2 u = d == 0 ? sampler->GetPixel2D() : sampler->Get2D();
                    x[d] += double(u.x) / n;
                    xy[d] += double(u.x) * double(u.y) / n;
                    board[d] += (int(u.x * 7) + int(u.y * 7)) % 2 / n;
                }
            }
        for (int d = 0; d < 8; ++d) {
            EXPECT_NEAR(x[d], 0.5, 5 * std::sqrt(1 / 12.0 / n)) << setting.Name() << d;
            EXPECT_NEAR(xy[d], 0.25, 5 * std::sqrt(7 / 144.0 / n)) << setting.Name() << d;
            EXPECT_NEAR(board[d], 24 / 49.0, 5 * std::sqrt(0.25 / n)) << setting.Name() << d;
        }
    }
}

TEST(Samplers, StratificationBeatsIndependence) {
    // Variance of the mean of x y over a pixel's 64 samples: (7/144)/64 = 7.6e-4 when independent. In 8 x 8
    // strata, or in any such net, each sample varies by at most its box: gradient^2/12/64 = 1/1152 of x y's
    // slope, 1e-5 in all.
    for (const Setting& setting : kSettings) {
        const auto sampler = Make(setting, 64, {64, 64});
        test::RunningMean means;
        for (int p = 0; p < 256; ++p) {
            double sum = 0;
            for (const Point2 u : PixelPoints(*sampler, {p % 16, p / 16}, 64)) sum += double(u.x * u.y) / 64;
            means.Add(sum);
        }
        EXPECT_EQ(means.Variance() < 6e-5, setting.name != "independent")
            << setting.Name() << means.Variance();
    }
}

/// Mean over many pairs of the product of two values, each shifted and scaled to mean 0 and variance 1.
class Correlation {
  public:
    void Add(float a, float b) { mean_.Add(12 * (double(a) - 0.5) * (double(b) - 0.5)); }
    double Mean() const { return mean_.Mean(); }
    test::Outcome Result(const std::string& what) const { return test::ZTest(mean_, 0, 0, what); }

  private:
    test::RunningMean mean_;
};

/// Between pairs of dimensions of one sample, over all samples of 16 x 16 pixels. `mix` of the second value
/// is copied from the first.
test::Outcome DimensionsCorrelate(const Setting& setting, float mix, uint64_t seed) {
    const auto sampler = Make(setting, 16, {16, 16}, int(uint32_t(seed)));
    const int count = 24;
    std::vector<Correlation> correlations(count * count);
    for (int p = 0; p < 256 * 16; ++p) {
        const std::vector<float> v = Values(*sampler, {p / 16 % 16, p / 256}, p % 16, count);
        for (size_t a = 0; a < count; ++a)
            for (size_t b = 0; b < a; ++b)
                correlations[a * count + b].Add(v[a], mix * v[a] + (1 - mix) * v[b]);
    }
    std::vector<test::Outcome> outcomes;
    for (size_t a = 0; a < count; ++a)
        for (size_t b = 0; b < a; ++b)
            outcomes.push_back(correlations[a * count + b].Result(fmt::format("dimensions {} and {}", a, b)));
    return test::WorstOf(outcomes);
}

/// Between the same dimensions of 400 pairs of pixels that are `offset` apart.
Correlation OfPixels(const Setting& setting, Int2 offset, uint64_t seed) {
    const auto sampler = Make(setting, 16, {600, 600}, int(uint32_t(seed)));
    Correlation correlation;
    Rng rng(seed);
    for (int p = 0; p < 400; ++p) {
        const Int2 pixel(int(rng.UniformInt(300)), int(rng.UniformInt(300)));
        const int index = int(rng.UniformInt(16));
        const std::vector<float> a = Values(*sampler, pixel, index, 24),
                                 b = Values(*sampler, pixel + offset, index, 24);
        for (size_t d = 0; d < 24; ++d) correlation.Add(a[d], b[d]);
    }
    return correlation;
}

const std::vector<Int2> kOffsets = {{128, 0}, {0, 243}, {128, 243}, {256, 256}};

TEST(Samplers, DimensionsAreUncorrelated) {
    // Randomised kinds only: without, the sequences are what they are.
    const double alpha = test::SidakAlpha(1e-3, int(kSettings.size()));
    for (const Setting& setting : kSettings) {
        if (setting.randomization == "none") continue;
        EXPECT_TRUE(test::Passes(test::FullTestName() + setting.Name(), alpha,
                                 [&](uint64_t seed) { return DimensionsCorrelate(setting, 0, seed); }));
    }
    // Negative control: a correlation r over n pairs is r sqrt(n) standard errors, here 0.24 * 64 = 15.
    EXPECT_LT(DimensionsCorrelate(kSettings[0], 0.2f, 1).pValue, 1e-12);
}

TEST(Samplers, PixelsAreUncorrelated) {
    const double alpha = test::SidakAlpha(1e-3, int(kOffsets.size() * kSettings.size()));
    for (const Setting& setting : kSettings)
        for (const Int2 offset : kOffsets) {
            // One scramble serves all pixels of a global sequence, so what the sequence has between far
            // points stays; but no two pixels may have the same numbers, or their mirror images.
            if (setting.name == "sobol" || setting.name == "halton") {
                EXPECT_LT(std::abs(OfPixels(setting, offset, 1).Mean()), 0.3) << setting.Name();
                continue;
            }
            if (setting.randomization == "none") continue;
            EXPECT_TRUE(test::Passes(test::FullTestName() + setting.Name(), alpha, [&](uint64_t seed) {
                return OfPixels(setting, offset, seed).Result(setting.Name());
            }));
        }
    // Negative control: pixels that have the same numbers are sqrt(9600) = 98 standard errors off.
    EXPECT_LT(OfPixels(kSettings[0], {0, 0}, 1).Result("").pValue, 1e-12);
    EXPECT_GT(OfPixels(kSettings[0], {0, 0}, 1).Mean(), 0.9);
}

TEST(Samplers, ContinueBeyondTheirLastDimensionWithFreshNumbers) {
    for (const Setting& setting : kSettings) {
        const auto sampler = Make(setting, 16);
        std::set<float> seen;
        for (const float value : Values(*sampler, {2, 3}, 4, 600))
            if (setting.randomization != "none") seen.insert(value);
        // 600 of 2^24 values: 0.01 coincidences are expected.
        EXPECT_TRUE(setting.randomization == "none" || seen.size() >= 598) << setting.Name();
    }
}

TEST(Samplers, HaveTheirDefaultAndRoundedCounts) {
    EXPECT_EQ(Make("independent", {})->SamplesPerPixel(), 4);
    for (const std::string name : {"stratified", "halton", "sobol", "paddedsobol", "zsobol"})
        EXPECT_EQ(Make(name, {})->SamplesPerPixel(), 16) << name;
    for (const std::string name : {"independent", "halton", "sobol", "paddedsobol"}) {
        EXPECT_EQ(Make(name, {Integer("pixelsamples", 100)})->SamplesPerPixel(), 100) << name;
        EXPECT_EQ(Make(name, {Integer("pixelsamples", 100)}, 7)->SamplesPerPixel(), 7) << name;
    }
    EXPECT_EQ(Make("zsobol", {Integer("pixelsamples", 100)})->SamplesPerPixel(), 64);
    EXPECT_EQ(Make("zsobol", {}, 100)->SamplesPerPixel(), 64);
    EXPECT_EQ(Make("zsobol", {}, 1)->SamplesPerPixel(), 1);
    for (const int count : {1, 7, 12, 64, 100})
        EXPECT_EQ(Make("stratified", {Integer("xsamples", 3)}, count)->SamplesPerPixel(), count);
    // 12 becomes 4 x 3.
    EXPECT_TRUE(OnePerBox(PixelPoints(*Make("stratified", {}, 12), {0, 0}, 12), 4, 3));
}

TEST(Samplers, TheSeedOfTheSceneTakesPrecedence) {
    const auto a = Make("zsobol", {Integer("seed", 9)}, 16, {16, 16}, 1),
               b = Make("zsobol", {}, 16, {16, 16}, 9);
    EXPECT_EQ(Values(*a, {1, 2}, 3, 30), Values(*b, {1, 2}, 3, 30));
}

TEST(Samplers, ImpossibleParametersAreErrors) {
    for (const std::string name : {"independent", "halton", "sobol", "paddedsobol", "zsobol"}) {
        for (const int count : {0, -5, (1 << 24) + 1})
            EXPECT_THROW(Make(name, {Integer("pixelsamples", count)}), SceneError) << name;
        EXPECT_THROW(Make(name, {}, 0), SceneError) << name;
    }
    EXPECT_THROW(Make("stratified", {Integer("xsamples", 0)}), SceneError);
    EXPECT_THROW(Make("stratified", {Integer("xsamples", 100000), Integer("ysamples", 100000)}), SceneError);
    EXPECT_ANY_THROW(Make("stratified", {Integer("pixelsamples", 16)}));
    EXPECT_THROW(Make("halton", {String("randomization", "fastowen")}), SceneError);
    for (const std::string name : {"halton", "sobol", "paddedsobol", "zsobol"})
        EXPECT_THROW(Make(name, {String("randomization", "owens")}), SceneError) << name;
}

}  // namespace
}  // namespace lacquer::samplers_test
