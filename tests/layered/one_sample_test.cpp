// Paths drawn by walks from both ends.
#include "layered/paths/half_vectors/one_sample.h"

#include <gtest/gtest.h>

#include "layered/agreement.h"
#include "layered/path_bias.h"

namespace lacquer::layered::test::one_sample_test {

namespace {

constexpr double kFamily = 1e-3;  ///< chance that a test of many cases raises a false alarm
constexpr auto kImportance = TransportMode::Importance;

std::vector<PathCase> Cases() {
    const Layer ellipse = Dielectric(Alphas(0.3f, 0.08f), 1.5f), sheet = Dielectric(0.2f, 1 / 1.5f);
    return {
        {"coat", {Dielectric(0.2f, 1.5f), Metal(0.1f)}},
        {"smooth_coat", {Dielectric(0.05f, 1.5f), Metal(0.5f)}, false, false, kImportance},
        {"rough_coat", {Dielectric(0.5f, 1.5f), Metal(0.05f)}},
        {"beckmann", {Dielectric(0.3f, 1.5f, kBeckmann), Metal(0.2f, kBeckmann)}, false, false, kImportance},
        {"mixed", {Dielectric(0.2f, 1.5f), Metal(0.2f, kBeckmann)}},
        {"anisotropic", {Rotated(30, ellipse), Metal(Alphas(0.05f, 0.3f))}},
        {"absorber", {Dielectric(0.2f, 1.4f), Absorber(Lanes(0.2f, 0.5f, 1, 2)), Metal(0.2f)}},
        {"sheet", {Dielectric(0.1f, 1.5f), sheet}, true},
        {"sheet_reflects", {Dielectric(0.1f, 1.5f), sheet}, false, false, kImportance},
        {"sheet_from_below", {Dielectric(0.1f, 1.5f), sheet}, true, true, kImportance},
        {"sheet_reflects_below", {Dielectric(0.1f, 1.5f), sheet}, false, true},
        {"anisotropic_sheet", {ellipse, Dielectric(Alphas(0.1f, 0.4f), 1.2f)}, true, false, kImportance},
        {"smaller_index", {Dielectric(0.1f, 0.8f), Metal(0.2f)}},
        {"into_water", {Dielectric(0.2f, 1.5f), Dielectric(0.1f, 0.9f)}, true},
        {"three", {Dielectric(0.1f, 1.5f), Dielectric(0.3f, 1.2f), sheet}, true},
        {"three_below",
         {Dielectric(0.1f, 1.5f), Absorber(0.5f), Dielectric(0.3f, 1.2f), sheet},
         true,
         true,
         kImportance},
    };
}

int NumSamples() { return Scaled(60000); }

// Power: the differences have standard errors of 0.4 to 1.0 % (recorded); five of them are found.
TEST(OneSample, IsRightOnAverage) {
    const auto rows = Cases();
    for (const PathCase& row : rows) {
        double error = 0;
        EXPECT_TRUE(
            Passes(FullTestName() + row.name, SidakAlpha(kFamily, int(rows.size())), [&](uint64_t seed) {
                const PathBias bias = JudgeByWalks(row, EstimateByOneSample, NumSamples(), seed);
                error = bias.RelativeError();
                return BiasOutcome(row, bias);
            }));
        RecordProperty(row.name, std::to_string(100 * error) + " %");
    }
}

/// Sample() and Pdf(), which the scale mixture uses.
SampledSpectrum EstimateInTwoSteps(const InterfacePath& path, const BxDFContext& context) {
    const OneSample oneSample(path);
    InnerDirections inner;
    if (!oneSample.Sample(path, context, &inner)) return SampledSpectrum(0);
    const PathTerms terms = EvaluatePathTerms(path, inner, context.mode);
    if (!terms.value) return terms.value;
    return terms.value * (1 / oneSample.Pdf(path, terms));
}

// One estimate by Estimate() and one in two steps from the same random numbers are the same but for rounding.
TEST(OneSample, EstimatesAreValueOverDensity) {
    for (const PathCase& row : Cases()) {
        Arena arena;
        const Stack stack = row.Build(arena);
        Rng pairs(SeedOf(FullTestName() + row.name));
        int numPositive = 0;
        for (const auto& [wo, wi] : PairsOf(row, stack, 300, pairs)) {
            InterfacePath path;
            ASSERT_TRUE(FindShortestPath(stack, wo, wi, InterfacePath::kMaxEvents, &path));
            Rng a = pairs, b = pairs;
            const auto quick = EstimateByOneSample(path, {row.mode, Lobes::BothSides, &a});
            const auto slow = EstimateInTwoSteps(path, {row.mode, Lobes::BothSides, &b});
            ASSERT_TRUE(quick.IsValid());
            numPositive += bool(quick);
            // The drawn directions are evaluated again, where tails of narrow lobes magnify their rounding.
            EXPECT_NEAR(double(quick.Sum()), double(slow.Sum()), 0.02 * double(quick.Sum())) << row.name;
            pairs.NextBits();
        }
        EXPECT_GT(numPositive, 100) << row.name;
    }
}

TEST(OneSample, TermsAreThoseOfTheInterfaces) {
    Arena arena;
    const PathCase row = Cases()[6];
    const Stack stack = row.Build(arena);
    const Vec3 wo = Normalize(Vec3(0.3f, -0.2f, 0.8f)), wi = Normalize(Vec3(-0.5f, 0.1f, 0.7f));
    InterfacePath path;
    ASSERT_TRUE(FindShortestPath(stack, wo, wi, 3, &path));
    const InnerDirections inner = {Normalize(Vec3(0.2f, 0, -1)), Normalize(Vec3(0.25f, -0.05f, 1))};
    const PathTerms terms = EvaluatePathTerms(path, inner, TransportMode::Radiance);
    const SampledSpectrum value = PathContribution(path, inner, TransportMode::Radiance);
    ASSERT_TRUE(bool(value));
    for (int i = 0; i < kNumWavelengths; ++i) EXPECT_NEAR(terms.value[i], value[i], 1e-5f * value[i]);
    // The way of the light: from wi down, up, and out to wo.
    const BxDFContext across{TransportMode::Radiance, Lobes::Transmission};
    const auto pdf = [](const StackInterface& interface, Vec3 from, Vec3 to, const BxDFContext& context) {
        return interface.Evaluate(from, to, context).pdf;
    };
    const StackInterface &top = stack.interfaces[0], &bottom = stack.interfaces[1];
    EXPECT_NEAR(terms.forward[0] / pdf(top, wi, inner[0], across), 1, 1e-4f);
    EXPECT_NEAR(terms.forward[1] / pdf(bottom, -inner[0], inner[1], {}), 1, 1e-4f);
    EXPECT_NEAR(terms.backward[1] / pdf(bottom, inner[1], -inner[0], {}), 1, 1e-4f);
    EXPECT_NEAR(terms.backward[2] / pdf(top, wo, -inner[1], across), 1, 1e-4f);
    // On the wrong side there is nothing.
    EXPECT_FALSE(bool(EvaluatePathTerms(path, {-inner[0], inner[1]}, TransportMode::Radiance).value));
}

TEST(OneSample, NegativeControlThreePercentTooBrightIsFound) {
    const auto brighter = [](const InterfacePath& path, const BxDFContext& context) {
        return EstimateByOneSample(path, context) * (Scaled(8) == 8 ? 1.03f : 1.12f);
    };
    const PathCase row = Cases()[0];
    const PathBias bias = CompareWithWalks(row, brighter, 2 * NumSamples(), SeedOf(FullTestName()));
    EXPECT_LT(BiasOutcome(row, bias).pValue, 1e-3) << bias.Relative() << " +- " << bias.RelativeError();
}

TEST(OneSample, NegativeControlTheDensityOfOneMeetingOnlyIsFound) {
    const auto forgetful = [](const InterfacePath& path, const BxDFContext& context) {
        InnerDirections inner;
        if (!OneSample(path).Sample(path, context, &inner)) return SampledSpectrum(0);
        const PathTerms terms = EvaluatePathTerms(path, inner, context.mode);
        return terms.value ? terms.value * (1 / (terms.forward[0] * terms.backward[2])) : terms.value;
    };
    const PathCase row = Cases()[0];
    const PathBias bias = CompareWithWalks(row, forgetful, NumSamples(), SeedOf(FullTestName()));
    EXPECT_LT(BiasOutcome(row, bias).pValue, 1e-6) << bias.Relative() << " +- " << bias.RelativeError();
}

}  // namespace
}  // namespace lacquer::layered::test::one_sample_test
