// Multiple products: paths of any length against samples of plain walks through the same sequence, and the
// estimator that is made of them. Its means on whole stacks are in product_estimators_test.cpp.
#include "layered/paths/products/multiple_product.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "layered/connection_walk.h"
#include "layered/paths/half_vectors/one_sample.h"
#include "layered/paths/interface_sequences.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::layered::test::multiple_product_test {

namespace {

constexpr auto kImportance = TransportMode::Importance;

struct Case {
    std::string name;
    std::vector<Layer> layers;
    std::vector<int> sequence;  ///< in the order of light
    TransportMode mode = TransportMode::Radiance;
};

std::vector<Case> Cases() {
    const auto glass = [](float alpha, float eta) { return Dielectric(alpha, eta, kBeckmann); };
    const Layer metal = Metal(0.1f, kBeckmann), smooth = Mirror(0.03f, kBeckmann);
    const std::vector<Layer> pane = {glass(0.2f, 1.5f), glass(0.1f, 1 / 1.5f)},
                             sheet = {glass(0.03f, 1.5f), glass(0.03f, 1 / 1.5f)};
    return {
        {"f_01", pane, {0, 1}},
        {"f_10", pane, {1, 0}, kImportance},
        {"f_010", {glass(0.3f, 1.5f), metal}, {0, 1, 0}},
        {"f_010_wide_end", {glass(0.4f, 1.5f), Metal(0.03f, kBeckmann)}, {0, 1, 0}, kImportance},
        {"f_010_absorber", {glass(0.2f, 1.5f), Absorber(Lanes(0.2f, 0.5f, 1, 2)), metal}, {0, 1, 0}},
        {"f_012", {glass(0.2f, 1.5f), glass(0.1f, 1.2f), glass(0.1f, 1 / 1.8f)}, {0, 1, 2}},
        {"f_210", {glass(0.1f, 1.5f), glass(0.1f, 1.2f), glass(0.3f, 1 / 1.8f)}, {2, 1, 0}, kImportance},
        {"f_01010", {glass(0.2f, 1.5f), smooth}, {0, 1, 0, 1, 0}},
        {"f_0101", sheet, {0, 1, 0, 1}},
        {"f_01210", {glass(0.2f, 1.5f), glass(0.2f, 1.2f), metal}, {0, 1, 2, 1, 0}},
        {"f_01210_turned",
         {Rotated(40, glass(0.1f, 1.5f)), glass(0.3f, 1.2f), Absorber(0.3f), metal},
         {0, 1, 2, 1, 0},
         kImportance},
        {"f_0123210",
         {glass(0.1f, 1.3f), glass(0.1f, 1.2f), glass(0.1f, 1.2f), Metal(0.05f, kBeckmann)},
         {0, 1, 2, 3, 2, 1, 0}},
        {"f_0123",
         {glass(0.1f, 1.3f), glass(0.1f, 1.2f), glass(0.1f, 1 / 1.2f), glass(0.1f, 1 / 1.3f)},
         {0, 1, 2, 3}},
    };
}

/// Paths with lobes that are mixtures.
std::vector<Case> CasesOfMixtures() {
    const auto ggx = [](float alpha, float eta) { return Dielectric(alpha, eta); };
    return {
        {"ggx_f_01", {ggx(0.2f, 1.5f), ggx(0.1f, 1 / 1.5f)}, {0, 1}},
        {"ggx_f_010", {ggx(0.3f, 1.5f), Metal(0.1f)}, {0, 1, 0}},
        {"ggx_f_010_equal", {ggx(0.1f, 1.5f), Absorber(0.3f), Metal(0.1f)}, {0, 1, 0}, kImportance},
        {"ggx_f_010_rough", {ggx(0.1f, 1.5f), Metal(0.4f)}, {0, 1, 0}},
        {"ggx_f_010_over_beckmann", {ggx(0.2f, 1.5f), Metal(0.1f, kBeckmann)}, {0, 1, 0}, kImportance},
        {"beckmann_f_010_over_ggx", {Dielectric(0.2f, 1.5f, kBeckmann), Metal(0.1f)}, {0, 1, 0}},
        {"ggx_f_012", {ggx(0.2f, 1.5f), ggx(0.1f, 1.2f), ggx(0.1f, 1 / 1.8f)}, {0, 1, 2}},
        {"ggx_f_210", {ggx(0.1f, 1.5f), ggx(0.3f, 1.2f), ggx(0.3f, 1 / 1.8f)}, {2, 1, 0}, kImportance},
    };
}

struct DirectionPair {
    Vec3 wo, wi;
};

/// Light that is followed through the sequence: pairs in the path's lobes, or near them.
std::vector<DirectionPair> PairsAlong(const Case& row, const Stack& stack, int count, Rng& rng) {
    const float side = row.sequence[0] == 0 ? 1.f : -1.f;
    std::vector<DirectionPair> pairs;
    while (int(pairs.size()) < count) {
        const Vec3 wi = side * SampleCosineHemisphere(rng.Uniform2D());
        Vec3 from = wi;
        bool isValid = std::abs(wi.z) > 0.05f;
        for (size_t k = 0; k < row.sequence.size() && isValid; ++k) {
            const bool reflections =
                k > 0 && k + 1 < row.sequence.size() && row.sequence[k - 1] == row.sequence[k + 1];
            const BxDFContext context{!row.mode, reflections ? Lobes::Reflection : Lobes::Transmission, &rng};
            const auto sample = stack.interfaces[size_t(row.sequence[k])].Sample(from, context);
            isValid = sample && std::abs(sample->wi.z) > 0.05f;
            if (isValid) from = -sample->wi;
        }
        if (isValid) pairs.push_back({-from, wi});
    }
    return pairs;
}

struct Bias {
    RunningMean difference, reference;
    int numPairs = 0;
    double Relative() const { return difference.Mean() / reference.Mean(); }
    double RelativeError() const { return difference.StandardError() / reference.Mean(); }
};

/// What a control does to a product's estimate.
using Change = std::function<SampledSpectrum(SampledSpectrum)>;

/// The product's mean less that of plain walks, each pair of directions in units of its own mean and noise.
template <class Product = MultipleProduct>
Bias CompareWithWalks(const Case& row, const Change& change, int numSamples, uint64_t seed) {
    constexpr int kPairs = 16, kPilots = 256;
    constexpr double kNoisiest = 6;
    Arena arena;
    const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
    Rng rng(seed);
    const BxDFContext context{row.mode, Lobes::BothSides, &rng, false};
    Bias bias;
    for (const DirectionPair& pair : PairsAlong(row, stack, kPairs, rng)) {
        InterfacePath path;
        Product product;
        if (!SetInterfacePath(stack, pair.wo, pair.wi, row.sequence, &path) || !product.Set(path)) continue;
        const OneSample walks(path);
        RunningMean pilot;
        for (int i = 0; i < kPilots; ++i) pilot.Add(double(walks.Estimate(path, context).Average()));
        const double deviation = std::sqrt(pilot.Variance()), scale = pilot.Mean() + deviation;
        if (!(scale > 0) || deviation > kNoisiest * pilot.Mean()) continue;
        ++bias.numPairs;
        for (int i = 0; i < numSamples / kPairs; ++i) {
            const double reference = double(walks.Estimate(path, context).Average()) / scale;
            const double value = double(change(product.Estimate(row.mode, rng)).Average()) / scale;
            bias.reference.Add(reference);
            bias.difference.Add(value - reference);
        }
    }
    return bias;
}

SampledSpectrum Unchanged(SampledSpectrum value) { return value; }

/// Each case alone and all together.
template <class Product>
void ExpectMeansOfWalks(const std::vector<Case>& rows, int numSamples, const std::string& name) {
    double sum = 0, variance = 0;
    for (const Case& row : rows) {
        const Bias bias =
            CompareWithWalks<Product>(row, Unchanged, Scaled(numSamples), SeedOf(name + row.name));
        // Half of the pairs of f_01010 and f_0101 are too close to total reflection.
        EXPECT_GE(bias.numPairs, 4) << row.name;
        EXPECT_LT(std::abs(bias.Relative()), 4 * bias.RelativeError()) << row.name;
        testing::Test::RecordProperty(row.name, fmt::format("{:+.4f} +- {:.4f}, {}", bias.Relative(),
                                                            bias.RelativeError(), bias.numPairs));
        sum += bias.Relative();
        variance += Sqr(bias.RelativeError());
    }
    EXPECT_LT(std::abs(sum), 3.5 * std::sqrt(variance))
        << sum / double(rows.size()) << " +- " << std::sqrt(variance) / double(rows.size());
    testing::Test::RecordProperty("together", fmt::format("{:+.4f} +- {:.4f}", sum / double(rows.size()),
                                                          std::sqrt(variance) / double(rows.size())));
}

// Power: each case has a standard error of 0.3 to 1.5 % (recorded), all together one of 0.25 %.
TEST(MultipleProduct, HasTheMeanOfWalksAlongTheSameWay) {
    ExpectMeansOfWalks<MultipleProduct>(Cases(), 60000, FullTestName());
}
TEST(MultipleProduct, OfMixturesHasTheMeanOfWalksAlongTheSameWay) {
    ExpectMeansOfWalks<MultipleProductOfMixtures>(CasesOfMixtures(), 120000, FullTestName());
}
// The same code on single Gaussians.
TEST(MultipleProduct, OfMixturesHasTheMeanOfWalksWhereLobesAreGaussians) {
    std::vector<Case> rows = Cases();
    std::erase_if(rows, [](const Case& row) { return row.sequence.size() > 3; });
    ExpectMeansOfWalks<MultipleProductOfMixtures>(rows, 60000, FullTestName());
}

TEST(MultipleProduct, ControlsAreSeen) {
    const auto brighter = [](SampledSpectrum v) { return v * 1.02f; };
    const auto isSeen = [&](const std::vector<Case>& rows, const auto& compare) {
        double sum = 0, variance = 0;
        for (const Case& row : rows) {
            const Bias bias = compare(row, SeedOf(FullTestName() + row.name));
            sum += bias.Relative();
            variance += Sqr(bias.RelativeError());
        }
        return sum > 3.5 * std::sqrt(variance);
    };
    EXPECT_TRUE(isSeen(Cases(), [&](const Case& row, uint64_t seed) {
        return CompareWithWalks<MultipleProduct>(row, brighter, 60000, seed);
    }));
    EXPECT_TRUE(isSeen(CasesOfMixtures(), [&](const Case& row, uint64_t seed) {
        return CompareWithWalks<MultipleProductOfMixtures>(row, brighter, 120000, seed);
    }));
}

TEST(MultipleProduct, RefusesWhatGaussiansDoNotFit) {
    const auto sets = [](const std::vector<Layer>& layers, const std::vector<int>& sequence) {
        Arena arena;
        const Stack stack = StackCase{.name = "", .layers = layers}.Build(arena);
        const Vec3 wo = Normalize(Vec3(0.3f, 0.2f, 1)), wi = Normalize(Vec3(-0.2f, -0.2f, 1));
        InterfacePath path;
        return SetInterfacePath(stack, wo, wi, sequence, &path) && MultipleProduct().Set(path);
    };
    const Layer coat = Dielectric(0.2f, 1.5f, kBeckmann), metal = Metal(0.2f, kBeckmann);
    EXPECT_TRUE(sets({coat, metal}, {0, 1, 0}));
    EXPECT_TRUE(sets({coat, Metal(0.02f, kBeckmann)}, {0, 1, 0, 1, 0}));
    // Total reflection by the coat.
    EXPECT_FALSE(sets({coat, metal}, {0, 1, 0, 1, 0}));
    // Mixtures, other shapes, other models, beyond the tables, out of the denser side.
    EXPECT_FALSE(sets({Dielectric(0.2f, 1.5f), metal}, {0, 1, 0}));
    EXPECT_FALSE(sets({coat, Metal(0.2f)}, {0, 1, 0}));
    EXPECT_FALSE(sets({coat, Metal(Alphas(0.1f, 0.2f), kBeckmann)}, {0, 1, 0}));
    EXPECT_FALSE(sets({Dielectric(Alphas(0.1f, 0.2f), 1.5f, kBeckmann), metal}, {0, 1, 0}));
    EXPECT_FALSE(sets({coat, Diffuse(0.5f)}, {0, 1, 0}));
    EXPECT_FALSE(sets({Dielectric(0, 1.5f), metal}, {0, 1, 0}));
    EXPECT_FALSE(sets({coat, Metal(0.0015f, kBeckmann)}, {0, 1, 0}));
    EXPECT_FALSE(sets({Dielectric(0.2f, 3, kBeckmann), metal}, {0, 1, 0}));
    EXPECT_FALSE(sets({Dielectric(0.2f, 1 / 1.5f, kBeckmann), metal}, {0, 1, 0}));
}

TEST(MultipleProduct, TakesMixturesWhereTheyBeatPairs) {
    const auto isWorthwhile = [](const std::vector<Layer>& layers, const std::vector<int>& sequence) {
        Arena arena;
        const Stack stack = StackCase{.name = "", .layers = layers}.Build(arena);
        InterfacePath path;
        EXPECT_TRUE(SetInterfacePath(stack, {0, 0, 1}, {0, 0, 1}, sequence, &path));
        return MultipleProductIsWorthwhile(path);
    };
    const Layer coat = Dielectric(0.1f, 1.5f);
    EXPECT_TRUE(isWorthwhile({coat, Metal(0.1f)}, {0, 1, 0}));
    EXPECT_TRUE(isWorthwhile({coat, Metal(0.05f, kBeckmann)}, {0, 1, 0}));
    EXPECT_FALSE(isWorthwhile({coat, Metal(0.2f)}, {0, 1, 0}));
    EXPECT_FALSE(isWorthwhile({Dielectric(0.5f, 1.5f), Metal(0.2f)}, {0, 1, 0}));
    EXPECT_TRUE(isWorthwhile({coat, coat, coat}, {0, 1, 2}));
    EXPECT_FALSE(isWorthwhile({coat, coat}, {0, 1}));
    EXPECT_FALSE(isWorthwhile({coat, coat, Metal(0.1f)}, {0, 1, 2, 1, 0}));
}

TEST(MultipleProduct, LeavesRoughBasesAndManyTurnsToOthers) {
    const auto isWorthwhile = [](float base, const std::vector<int>& sequence) {
        Arena arena;
        const Layer coat = Dielectric(0.1f, 1.5f, kBeckmann);
        const Stack stack =
            StackCase{.name = "", .layers = {coat, coat, Metal(base, kBeckmann)}}.Build(arena);
        InterfacePath path;
        EXPECT_TRUE(SetInterfacePath(stack, {0, 0, 1}, {0, 0, 1}, sequence, &path));
        return MultipleProductIsWorthwhile(path);
    };
    EXPECT_TRUE(isWorthwhile(0.5f, {0, 1, 0}));
    EXPECT_TRUE(isWorthwhile(0.1f, {0, 1, 2, 1, 0}));
    EXPECT_FALSE(isWorthwhile(0.3f, {0, 1, 2, 1, 0}));
    EXPECT_TRUE(isWorthwhile(0.1f, {0, 1, 0, 1, 0}));
    EXPECT_FALSE(isWorthwhile(0.1f, {0, 1, 2, 1, 2, 1, 0}));
}

TEST(Ways, AreAllWaysOfTheirLength) {
    const auto count = [](size_t numInterfaces, int numEvents, bool isReflection, int reflections) {
        std::vector<StackInterface> interfaces(numInterfaces);
        Stack stack;
        stack.interfaces = interfaces;
        int n = 0;
        ForEachInterfaceSequence(stack, {0, 0, 1}, {0, 0, isReflection ? 1.f : -1.f}, numEvents,
                                 [&](std::span<const int> sequence) {
                                     n += reflections < 0 || NumReflections(sequence) == reflections;
                                     return true;
                                 });
        return n;
    };
    EXPECT_EQ(count(2, 3, true, -1), 1);
    EXPECT_EQ(count(2, 4, true, -1), 0);
    EXPECT_EQ(count(2, 5, true, 3), 1);
    EXPECT_EQ(count(3, 5, true, -1), 2);
    EXPECT_EQ(count(3, 5, true, 1), 1);
    EXPECT_EQ(count(3, 7, true, -1), 4);
    EXPECT_EQ(count(4, 7, true, -1), 5);
    EXPECT_EQ(count(2, 2, false, 0), 1);
    EXPECT_EQ(count(3, 3, false, -1), 1);
    EXPECT_EQ(count(3, 5, false, -1), 2);
    EXPECT_EQ(count(3, 2, false, -1), 0);
}

// ---- The estimator ----------------------------------------------------------------------------------------

RunningMean MeanOf(const std::function<SampledSpectrum(const BxDFContext&)>& estimate, int n, uint64_t seed) {
    Rng rng(seed);
    RunningMean mean;
    for (int i = 0; i < n; ++i) mean.Add(double(estimate({.rng = &rng, .needsPdf = false}).Average()));
    return mean;
}

// Direct paths and the walks that leave them out are all light; walks that leave out all paths of that length
// lose what turns more often. Power: a part of 3 %.
TEST(KnownPaths, ExcludeTheKnownPathsAndNothingElse) {
    Arena arena;
    const Stack stack = StackCase{.name = "",
                                  .layers = {Dielectric(0.1f, 1.5f, kBeckmann),
                                             Dielectric(0.1f, 1.5f, kBeckmann), Mirror(0.1f, kBeckmann)}}
                            .Build(arena);
    const Vec3 wo = Normalize(Vec3(0.7f, 0, 1)), wi = Normalize(Vec3(-0.7f, 0.1f, 1));
    const auto walks = [&](KnownPaths known) {
        return MeanOf(
            [&](const BxDFContext& context) {
                return ConnectionWalk<WalkPolicy>(stack, context, 5, known).Estimate(wo, wi);
            },
            Scaled(200000), SeedOf(FullTestName() + std::to_string(known.directVertices)));
    };
    double direct = 0, variance = 0, others = 0, othersVariance = 0;
    for (const std::vector<int>& sequence : {std::vector{0, 1, 0}, {0, 1, 2, 1, 0}, {0, 1, 0, 1, 0}}) {
        InterfacePath path;
        ASSERT_TRUE(SetInterfacePath(stack, wo, wi, sequence, &path));
        const RunningMean mean = MeanOf(
            [&](const BxDFContext& context) { return EstimateByOneSample(path, context); }, Scaled(200000),
            SeedOf(FullTestName() + std::to_string(sequence.size()) + std::to_string(sequence[2])));
        (NumReflections(sequence) == 1 ? direct : others) += mean.Mean();
        (NumReflections(sequence) == 1 ? variance : othersVariance) += Sqr(mean.StandardError());
    }
    const RunningMean all = walks({}), rest = walks({0, 5}), none = walks({5, 0});
    EXPECT_NEAR(all.Mean(), direct + others,
                4 * std::hypot(all.StandardError(), std::sqrt(variance + othersVariance)));
    EXPECT_NEAR(rest.Mean(), others, 4 * std::hypot(rest.StandardError(), std::sqrt(othersVariance)));
    EXPECT_EQ(none.Mean(), 0);
    // What a walk that forgot the turns would lose can be seen.
    EXPECT_GT(others, 6 * std::sqrt(othersVariance));
}

// Measured: 1.9 and 4; the standard error of each quotient is below 10 %.
TEST(ProductNoise, OfLongerPathsIsBelowThatOfBidirectional) {
    struct Row {
        std::vector<Layer> layers;
        bool transmits;
        double least;
    };
    const Layer top = Dielectric(0.1f, 1.5f, kBeckmann), middle = Dielectric(0.1f, 1.2f, kBeckmann);
    for (const Row& row : {Row{{top, middle, Metal(0.1f, kBeckmann)}, false, 2},
                           Row{{top, middle, Dielectric(0.1f, 1 / 1.8f, kBeckmann)}, true, 4}}) {
        Arena arena;
        const Stack stack = StackCase{.name = "", .layers = row.layers}.Build(arena);
        const Vec3 wo = Normalize(Vec3(0.3f, 0, 1)),
                   wi = Normalize(Vec3(-0.25f, 0.05f, row.transmits ? -1.f : 1.f));
        const auto noise = [&](const char* name) {
            const LayeredEstimator* estimator = FindEstimator(name);
            return std::sqrt(MeanOf(
                                 [&](const BxDFContext& context) {
                                     return estimator->Evaluate(stack, wo, wi, context, 5);
                                 },
                                 Scaled(20000), SeedOf(FullTestName() + name))
                                 .Variance());
        };
        EXPECT_GT(noise("bidirectional") / noise("multiproduct:5"), row.least);
    }
}

}  // namespace
}  // namespace lacquer::layered::test::multiple_product_test
