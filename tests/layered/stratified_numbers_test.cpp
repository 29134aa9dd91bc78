// Estimates of stacks by dimensions of the pixel's sampler: what they gain over pseudo-random numbers, and
// that they remain right in the mean.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>

#include "layered/stack_cases.h"
#include "pbrt/base/bxdf_numbers.h"
#include "support/statistics.h"

namespace lacquer::layered::test::stratified_numbers_test {

using namespace lacquer::test;

namespace {

std::unique_ptr<Sampler> MakeSampler(const std::string& name, int samples) {
    const Params params("sampler \"" + name + "\"", {}, {}, nullptr);
    return Registry<SamplerKind>::Find(name)({params, {4096, 4096}, samples, 0, nullptr});
}
Vec3 Direction(float degrees, float azimuthDegrees = 0) {
    const float theta = Radians(degrees);
    return SphericalDirection(std::sin(theta), std::cos(theta), Radians(azimuthDegrees));
}
const Vec3 kWo = Direction(30), kWi = Direction(45, 180);

/// A stack with an estimator and the density of Guo et al.
class Subject {
  public:
    Subject(const std::string& estimator, const std::vector<Layer>& layers, int numSamples = 1,
            int maxVertices = kMaxPathVertices) {
        StackCase row;
        row.layers = layers;
        LayeredOptions options;
        options.estimator = FindEstimator(estimator);
        options.pdf = FindPdf("approximate");
        options.numSamples = numSamples;
        options.maxVertices = maxVertices;
        bxdf_ = row.MakeBxDF(arena_, options);
    }
    double Value(const BxDFContext& context) const {
        BxDFContext value = context;
        value.needsPdf = false;
        return double(bxdf_->Evaluate(kWo, kWi, value).f.Average());
    }
    double Density(const BxDFContext& context) const { return double(bxdf_->Pdf(kWo, kWi, context)); }
    /// Light that leaves on the left, over the cosine: an integral over Sample()'s directions.
    double LightToTheLeft(const BxDFContext& context) const {
        const float lobe = context.rng->Uniform();
        const auto sample = bxdf_->Sample(kWo, {lobe, context.rng->Uniform2D()}, context);
        return sample && sample->wi.x < 0 ? double(sample->weight.Average()) : 0;
    }

  private:
    Arena arena_;
    const LayeredBxDF* bxdf_;
};

/// Means of `samples` estimates in each of `pixels`, with numbers of a sampler or, where that knows no sets
/// of points, pseudo-random ones.
template <class Estimate>
RunningMean PixelMeans(const std::string& sampler, int samples, int pixels, uint64_t seed,
                       const Estimate& estimate) {
    const auto made = MakeSampler(sampler, samples);
    const int firstPixel = int(Hash(seed) % 4096);
    RunningMean means;
    for (int pixel = 0; pixel < pixels; ++pixel) {
        double sum = 0;
        for (int i = 0; i < samples; ++i) {
            made->StartPixelSample({pixel % 4096, (firstPixel + pixel / 4096) % 4096}, i);
            Rng rng(Hash(seed, pixel, i));
            BxDFDimensions dimensions(*made);
            dimensions.StartVertex(1);
            sum += estimate(BxDFContext{.rng = &rng, .dimensions = &dimensions});
        }
        means.Add(sum / samples);
    }
    return means;
}

const std::vector<Layer> kRoughOverMetal = {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.1f, kBeckmann)};
const std::vector<Layer> kGgxOverMetal = {Dielectric(0.1f, 1.5f), Metal(0.2f)};
const std::vector<Layer> kVarnish = {Dielectric(0.1f, 1.5f), Medium(1, 0.8f, HG(0.5f)), Metal(0.2f)};
const std::vector<Layer> kSmoothCoat = {Dielectric(0, 1.5f), Metal(0.2f)};
const std::vector<Layer> kTwoCoats = {Dielectric(0.2f, 1.5f, kBeckmann), Dielectric(0.15f, 1.3f, kBeckmann),
                                      Metal(0.1f, kBeckmann)};

/// Random numbers of a query, by the path's generator and by the counter.
double NumbersOfQuery(const Subject& subject, const std::string& sampler) {
    const auto made = MakeSampler(sampler, 64);
    RunningMean numbers;
    for (int i = 0; i < 64; ++i) {
        made->StartPixelSample({0, 0}, i);
        Rng rng(Hash(i));
        const Rng start = rng;
        BxDFDimensions dimensions(*made);
        dimensions.StartVertex(1);
        BxDFCounters counters;
        subject.Value({.rng = &rng, .counters = &counters, .dimensions = &dimensions});
        numbers.Add(double(rng.CountSince(start)) + double(counters.numbers));
    }
    return numbers.Mean();
}

/// What a query costs: adaptive sampling goes by it.
TEST(StratifiedNumbersCount, TellsLongWalksFromShortOnes) {
    const std::vector<Layer> milk = {Dielectric(0.1f, 1.5f), Medium(30, 0.999f, HG(0)), Metal(0.2f)};
    for (const char* sampler : {"paddedsobol", "independent"}) {
        const double coat = NumbersOfQuery(Subject("bidirectional", kGgxOverMetal), sampler);
        const double deep = NumbersOfQuery(Subject("bidirectional", milk), sampler);
        EXPECT_GT(coat, 8) << sampler;
        EXPECT_GT(deep, 3 * coat) << sampler;
    }
}

// ---- What they gain ---------------------------------------------------------------------------------------

struct Gain {
    std::string name, estimator;
    std::vector<Layer> layers;
    double at64, at256;  ///< what the root of the mean square error must be divided by at least
    int maxVertices = kMaxPathVertices;
};
const std::vector<Gain> kGains = {
    {"shortest_path", "halfvector", kRoughOverMetal, 1.25, 1.15, 3},
    {"rough_over_metal", "halfvector", kRoughOverMetal, 1.15, 1.1},
    {"rough_over_metal", "auto", kRoughOverMetal, 1.15, 1.1},
    {"rough_over_metal", "bidirectional", kRoughOverMetal, 1.9, 2.1},
    {"ggx_over_metal", "halfvector", kGgxOverMetal, 1.1, 1.2},
    {"ggx_over_metal", "auto", kGgxOverMetal, 1.1, 1.1},
    {"ggx_over_metal", "bidirectional", kGgxOverMetal, 2.1, 2.1},
    {"varnish", "auto", kVarnish, 1.3, 1.3},
    {"smooth_coat", "auto", kSmoothCoat, 1.1, 1.1},
    {"two_coats", "auto", kTwoCoats, 1.3, 1.3},
};

class StratifiedNumbers : public testing::TestWithParam<Gain> {
  protected:
    /// The quotient of the standard errors of pixels, pseudo-random over those of a sampler. Over 512 pixels
    /// with errors near a Gaussian its standard error is 4.4 %.
    static double GainOf(const Gain& gain, const std::string& sampler, int samples) {
        constexpr int kPixels = 512;
        const Subject subject(gain.estimator, gain.layers, 1, gain.maxVertices);
        const auto value = [&](const BxDFContext& context) { return subject.Value(context); };
        const uint64_t seed = SeedOf(FullTestName());
        const double random = PixelMeans("independent", samples, Scaled(kPixels), seed, value).Variance();
        return std::sqrt(random /
                         PixelMeans(sampler, samples, Scaled(kPixels), Hash(seed), value).Variance());
    }
};

TEST_P(StratifiedNumbers, ConvergeFaster) {
    const double at64 = GainOf(GetParam(), "paddedsobol", 64), at256 = GainOf(GetParam(), "paddedsobol", 256);
    RecordProperty("at64", fmt::format("{:.2f}", at64));
    RecordProperty("at256", fmt::format("{:.2f}", at256));
    EXPECT_GT(at64, GetParam().at64);
    EXPECT_GT(at256, GetParam().at256);
}

// The control: where the sampler has no sets of points nothing is gained, and the quotient says so within
// four of its standard errors, with tails as heavy as these estimates have.
TEST_P(StratifiedNumbers, GainNothingFromPseudoRandomOnes) {
    EXPECT_NEAR(GainOf(GetParam(), "independent", 64), 1, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Stacks, StratifiedNumbers, testing::ValuesIn(kGains),
                         [](const auto& tested) { return tested.param.name + "_" + tested.param.estimator; });

// All samplers that have an order of samples in a pixel give points, and the error falls with each.
TEST(StratifiedNumbersOfSamplers, GainWithEachOfThem) {
    const Subject subject("bidirectional", kGgxOverMetal);
    const auto value = [&](const BxDFContext& context) { return subject.Value(context); };
    const auto variance = [&](const std::string& name, uint64_t seed) {
        return PixelMeans(name, 64, Scaled(512), Hash(SeedOf(FullTestName()), seed), value).Variance();
    };
    const double random = variance("independent", 0);
    for (const char* name : {"halton", "paddedsobol", "pmj02bn", "sobol", "stratified", "zsobol"})
        EXPECT_GT(random / variance(name, 1), Sqr(1.8)) << name;
}

// ---- That they are right ----------------------------------------------------------------------------------

struct Query {
    std::string name;
    std::function<double(const Subject&, const BxDFContext&)> estimate;
};
// Four samples a pixel, so that pixels differ by their scrambles. The weighted value is what light sampling
// adds to a pixel, its density as large as the mean one: numbers that value and density share would change
// its mean, as the control below does.
const std::vector<Query> kQueries = {
    {"value", [](const Subject& s, const BxDFContext& c) { return s.Value(c); }},
    {"density", [](const Subject& s, const BxDFContext& c) { return s.Density(c); }},
    {"sample", [](const Subject& s, const BxDFContext& c) { return s.LightToTheLeft(c); }},
    {"weighted_value",
     [](const Subject& s, const BxDFContext& c) { return s.Value(c) / (1 + s.Density(c)); }},
    {"product", [](const Subject& s, const BxDFContext& c) { return s.Value(c) * s.Density(c); }},
    {"two_values", [](const Subject& s, const BxDFContext& c) { return s.Value(c) * s.Value(c); }},
};

Outcome CompareMeans(const Subject& subject, const Query& query, uint64_t seed) {
    const auto estimate = [&](const BxDFContext& context) { return query.estimate(subject, context); };
    const RunningMean random = PixelMeans("independent", 4, Scaled(4000), Hash(seed, 1), estimate),
                      stratified = PixelMeans("paddedsobol", 4, Scaled(4000), Hash(seed, 2), estimate);
    const double error = std::hypot(random.StandardError(), stratified.StandardError());
    const double z = (stratified.Mean() - random.Mean()) / error;
    return {NormalTwoSided(z),
            fmt::format("{}: mean {} by pseudo-random numbers, {} by stratified ones, {} of "
                        "its standard errors apart",
                        query.name, random.Mean(), stratified.Mean(), z)};
}

// Power: errors of means of four standard errors, 1 to 5 %.
TEST(StratifiedNumbersMeans, AgreeWithPseudoRandomOnes) {
    for (const char* estimator : {"auto", "bidirectional", "halfvector"})
        for (const auto& layers : {kRoughOverMetal, kGgxOverMetal, kVarnish}) {
            const Subject subject(estimator, layers);
            for (const Query& query : kQueries)
                EXPECT_TRUE(Passes(fmt::format("{} {} {}", FullTestName(), estimator, query.name),
                                   SidakAlpha(1e-3, 54),
                                   [&](uint64_t seed) { return CompareMeans(subject, query, seed); }));
        }
}
TEST(StratifiedNumbersMeans, OfSeveralEstimatesAgree) {
    const Subject subject("bidirectional", kGgxOverMetal, 3);
    EXPECT_TRUE(Passes(FullTestName(), 1e-4,
                       [&](uint64_t seed) { return CompareMeans(subject, kQueries.front(), seed); }));
}
// The control: two values of one set of points, as if a path forgot that its vertex has been asked before.
TEST(StratifiedNumbersMeans, ControlSeesNumbersThatTwoQueriesShare) {
    const Subject subject("bidirectional", kGgxOverMetal);
    const Query shared{"shared", [](const Subject& s, const BxDFContext& c) {
                           const double first = s.Value(c);
                           c.dimensions->StartVertex(1);
                           return first * s.Value(c);
                       }};
    EXPECT_LT(CompareMeans(subject, shared, SeedOf(FullTestName())).pValue, 1e-6);
}

// The same samples, whatever was asked for before at other pixels: bits depend on nothing else.
TEST(StratifiedNumbersMeans, DoNotDependOnWhatWasAskedBefore) {
    const Subject subject("auto", kRoughOverMetal);
    const auto sampler = MakeSampler("zsobol", 16), other = sampler->Clone();
    for (int i : {11, 3, 3, 0}) {
        other->StartPixelSample({7, 9}, i);
        const auto valueOf = [&](Sampler& from) {
            from.StartPixelSample({2, 5}, i);
            Rng rng(Hash(i));
            BxDFDimensions dimensions(from);
            return subject.Value({.rng = &rng, .dimensions = &dimensions});
        };
        EXPECT_EQ(valueOf(*sampler), valueOf(*other));
    }
}

}  // namespace
}  // namespace lacquer::layered::test::stratified_numbers_test
