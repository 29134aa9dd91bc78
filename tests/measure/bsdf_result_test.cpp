// How often a sheet of correct estimators says that one differs, and whether it still finds a wrong one.
#include "measure/bsdf_result.h"

#include <gtest/gtest.h>

#include <random>

#include "measure/measure_fixtures.h"
#include "support/statistics.h"

namespace lacquer::measure::bsdf_result_test {
namespace {

using test::DirectionAt;
using test::FromText;

constexpr int kEstimators = 7;

/// A mean of grey values of standard deviation 1 around `mean`.
ColorMean Draw(std::mt19937_64& random, int count, double mean) {
    std::normal_distribution<double> normal(mean, 1);
    ColorMean m;
    for (int i = 0; i < count; ++i) m.Add(glm::dvec3(normal(random)));
    return m;
}

/// Of a material that reflects and transmits. @param shift  of the last estimator, in standard errors
BsdfResult MakeSheet(uint64_t seed, double shift) {
    std::mt19937_64 random(seed);
    BsdfResult r;
    r.transmits = true;
    r.sampled.smoothReflected = Draw(random, 64, 0);
    r.sampled.smoothTransmitted = Draw(random, 64, 0);
    for (int e = 0; e < kEstimators; ++e) {
        EstimatorResult estimator;
        const double mean = e == kEstimators - 1 ? shift / 8 : 0;
        estimator.energy = {Draw(random, 64, mean), Draw(random, 64, 0), 0};
        r.estimators.push_back(estimator);
    }
    return r;
}

bool SaysDiffers(const BsdfResult& sheet) {
    for (const EnergyAgreement& a : AgreementsWithSamples(sheet))
        if (!a.reflected.HoldsZero() || !a.transmitted.HoldsZero()) return true;
    return false;
}
/// As it was: each comparison for itself.
bool SaysDiffersOneByOne(const BsdfResult& sheet) {
    for (const EstimatorResult& e : sheet.estimators)
        if (!Agreement(e.energy.reflected, sheet.sampled.smoothReflected, 1).HoldsZero() ||
            !Agreement(e.energy.transmitted, sheet.sampled.smoothTransmitted, 1).HoldsZero())
            return true;
    return false;
}

TEST(AgreementsWithSamples, OneSheetInTwentySaysDiffersByChance) {
    constexpr int kSheets = 1000;
    int said = 0, oneByOne = 0;
    for (int i = 0; i < kSheets; ++i) {
        const BsdfResult sheet =
            MakeSheet(Hash(::lacquer::test::SeedOf(::lacquer::test::FullTestName()), i), 0);
        ASSERT_EQ(NumAgreements(sheet), size_t(2 * kEstimators));
        said += SaysDiffers(sheet);
        oneByOne += SaysDiffersOneByOne(sheet);
    }
    // 5 % at most, and little less: all comparisons share the samples, which makes false alarms come
    // together. A binomial rate of 1000 has a standard error of 0.7 %.
    EXPECT_LE(said, kSheets * 0.05 + 3.5 * 7);
    EXPECT_GE(said, kSheets * 0.02);
    // The control: without the correction every third sheet does.
    EXPECT_GE(oneByOne, kSheets * 0.25);
}

TEST(AgreementsWithSamples, FindAnEstimatorThatIsWrong) {
    // Five standard errors of the difference, which is that of two means: the limit of 14 comparisons
    // is 2.95, and noise hides one in fifty.
    int found = 0;
    for (int i = 0; i < 100; ++i)
        found += SaysDiffers(
            MakeSheet(Hash(::lacquer::test::SeedOf(::lacquer::test::FullTestName()), i), 5 * std::sqrt(2.0)));
    EXPECT_GE(found, 93);
}

/// Seven integrations of one material's lobe against samples of another.
int SheetsThatDiffer(const SceneMaterial& sampled, const SceneMaterial& integrated, int sheets) {
    int said = 0;
    for (int sheet = 0; sheet < sheets; ++sheet) {
        const uint64_t seed = Hash(::lacquer::test::SeedOf(::lacquer::test::FullTestName()), sheet);
        const LobeQuery query{*sampled.bsdf, DirectionAt(40, 20), TransportMode::Importance, seed};
        BsdfResult r;
        r.transmits = true;
        r.sampled = SampleLobe(query, 4096);
        const DirectionGuide guide = LearnGuide(query, r.sampled);
        for (int e = 0; e < kEstimators; ++e) {
            EstimatorResult estimator;
            estimator.energy = IntegrateLobe(
                {*integrated.bsdf, query.w, TransportMode::Importance, Hash(seed, e)}, guide, 1.5, 2048);
            r.estimators.push_back(estimator);
        }
        said += SaysDiffers(r);
    }
    return said;
}

TEST(AgreementsWithSamples, OfARoughDielectricHoldAndFindAnother) {
    const auto glass = [](const std::string& eta) {
        return FromText(
            "MakeNamedMaterial \"m\" \"string type\" \"dielectric\" \"bool remaproughness\" false "
            "\"float roughness\" .4 \"float eta\" " +
                eta,
            "m");
    };
    // Another index: a third more light is reflected, ten standard errors.
    const SceneMaterial right = glass("1.5"), wrong = glass("1.6");
    // At 5 % six or more of forty come once in 70 cases.
    EXPECT_LE(SheetsThatDiffer(right, right, 40), 6);
    EXPECT_GE(SheetsThatDiffer(right, wrong, 10), 9);
}

}  // namespace
}  // namespace lacquer::measure::bsdf_result_test
