#include "compare/box_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compare/experiment.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::compare::box_statistics_test {
namespace {

using test::FullTestName;
using test::SeedOf;

constexpr int kSide = 24;
const Bounds2i kAll{{0, 0}, {kSide, kSide}};

/// What a pixel should show: different in each, so that their noise is, too.
double Truth(int x, int y, int c) { return 0.2 + 0.05 * x + 0.02 * y + 0.1 * c; }

/// Noise of Monte Carlo renders is skewed: a mean of `samples` exponential variables, less their mean.
double Noise(Rng& rng, double samples) {
    // Few sums suffice for the skewness; a scale gives the variance.
    constexpr int kSums = 4;
    double sum = 0;
    for (int i = 0; i < kSums; ++i) sum -= std::log(1 - double(rng.Uniform()));
    return (sum / kSums - 1) * std::sqrt(kSums / samples);
}

/// One run: the truth with relative noise of variance 1 / samples, times `factor`.
Image MakeRun(Rng& rng, double samples, double factor = 1) {
    Image image({kSide, kSide}, {"R", "G", "B"});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c)
                image.Set({x, y}, c, float(factor * Truth(x, y, c) * (1 + Noise(rng, samples))));
    return image;
}

Reference ExactReference() {
    Reference reference;
    reference.image = Image({kSide, kSide}, {"R", "G", "B"});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c) reference.image.Set({x, y}, c, float(Truth(x, y, c)));
    return reference;
}

struct Group {
    std::vector<Image> images;
    Runs Pointers() const {
        Runs runs;
        for (const Image& image : images) runs.push_back(&image);
        return runs;
    }
};

Group MakeGroup(Rng& rng, int runs, double samples, double factor = 1) {
    Group group;
    for (int i = 0; i < runs; ++i) group.images.push_back(MakeRun(rng, samples, factor));
    return group;
}

/// The second group against the first.
BoxResult Against(const Group& baseline, const Group& other, const Reference& reference, uint64_t seed = 1) {
    return MeasureBox(kAll, reference, {baseline.Pointers(), other.Pointers()}, 0, seed)[1];
}

bool Holds(const Interval& interval, double value) { return interval.low <= value && value <= interval.high; }

/// Of 100 comparisons of two estimators of relative variance 1/16 and `factor` times that, in how many the
/// interval holds `ratio`.
int Coverage(double factor, double ratio) {
    const Reference reference = ExactReference();
    int held = 0;
    for (int repetition = 0; repetition < 100; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 16 / factor);
        held += Holds(Against(a, b, reference, Hash(repetition)).rmseReduction, ratio);
    }
    return held;
}

// An interval that held the truth in 75 % of all cases would pass with a probability of 0.1 %; one that holds
// it in 94 %, which is about what four runs allow, fails with 1 %. Nor is it wider than it need be: one that
// always holds the truth fails, too.
TEST(MeasureBox, AnEstimatorAgainstItselfGivesOne) {
    const int held = Coverage(1, 1);
    EXPECT_GE(held, 88);
    EXPECT_LE(held, 99);
}
TEST(MeasureBox, HalfTheTimeGivesTheRootOfTwo) { EXPECT_GE(Coverage(0.5, std::sqrt(2)), 88); }
TEST(MeasureBox, TenPercentOfRmseAreNoOne) { EXPECT_LE(Coverage(1.21, 1), 50); }

/// Of `repetitions` comparisons of four estimators with these relative variances, in how many one of the
/// first `numEqual` is called worse than the best.
int CalledWorse(const std::array<double, 4>& variances, size_t numEqual, int repetitions) {
    const Reference reference = ExactReference();
    int called = 0;
    for (int repetition = 0; repetition < repetitions; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        std::vector<Group> groups;
        for (const double variance : variances) groups.push_back(MakeGroup(rng, 4, 16 / variance));
        std::vector<Runs> runs;
        for (const Group& group : groups) runs.push_back(group.Pointers());
        const auto results = MeasureBox(kAll, reference, runs, 3, Hash(repetition));
        bool isWorse = false;
        for (size_t e = 0; e < numEqual; ++e) isWorse |= results[e].verdict == Verdict::Worse;
        called += isWorse;
        EXPECT_EQ(std::count_if(results.begin(), results.end(),
                                [](const BoxResult& r) { return r.verdict == Verdict::Best; }),
                  1);
    }
    return called;
}

// 5 of 100 are allowed, of 40 two; with a rate of 5 % there are seven or more once in 300 cases.
TEST(MeasureBox, EqualEstimatorsAreIndistinguishable) { EXPECT_LE(CalledWorse({1, 1, 1, 1}, 4, 40), 6); }
// The baseline with four times the variance does not matter for the others.
TEST(MeasureBox, AFarBaselineMakesNoDifferenceBetweenOthers) {
    EXPECT_LE(CalledWorse({1, 1, 1, 4}, 3, 40), 6);
}
// The control: one with 15 % more error is found, where that is 6 standard errors or so.
TEST(MeasureBox, MoreErrorIsTold) { EXPECT_GE(CalledWorse({1.32, 1, 1, 1}, 1, 20), 18); }

// Runs in each of which the whole image is noisier or less noisy, by half in its variance. Of 1000 such
// comparisons intervals hold the truth in 888, for four runs tell little of how runs differ; one that holds
// it in 70 % passes with a probability of 2 %. The control: without the stretching 243 hold it.
TEST(MeasureBox, ErrorsOfWholeImagesThatGoTogetherWidenIntervals) {
    const Reference reference = ExactReference();
    int held = 0, heldWithout = 0, seen = 0;
    for (int repetition = 0; repetition < 100; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        Group groups[2];
        for (Group& group : groups)
            for (int i = 0; i < 4; ++i) group.images.push_back(MakeRun(rng, 16 * (1 + Noise(rng, 4))));
        const BoxResult r = Against(groups[0], groups[1], reference, Hash(repetition));
        held += Holds(r.rmseReduction, 1);
        seen += r.sharedErrors > 1;
        const double value = std::log(r.rmseReduction.value);
        const double half = std::log(r.rmseReduction.high / r.rmseReduction.low) / 2;
        heldWithout += std::abs(value) <= half / r.sharedErrors;
    }
    EXPECT_GE(held, 80);
    EXPECT_GE(seen, 95);
    EXPECT_LE(heldWithout, 40);
}
// A test at 5 % of 100 comparisons of independent runs: more than 12 have a probability of 0.2 %.
TEST(MeasureBox, IndependentErrorsSeldomWidenIntervals) {
    const Reference reference = ExactReference();
    int widened = 0;
    for (int repetition = 0; repetition < 100; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 16);
        widened += Against(a, b, reference, Hash(repetition)).sharedErrors > 1;
    }
    EXPECT_LE(widened, 12);
}

TEST(MeasureBox, RatiosAreThoseAtEqualTime) {
    Rng rng(SeedOf(FullTestName()));
    // Twice the samples in twice the time is no gain.
    const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 32);
    const auto measure = [&](const std::vector<double>& seconds) {
        return MeasureBox(kAll, ExactReference(), {a.Pointers(), b.Pointers()}, 0, 1, seconds);
    };
    const auto asTheyAre = measure({}), atEqualTime = measure({1, 2});
    EXPECT_NEAR(asTheyAre[1].rmseReduction.value, std::sqrt(2), 0.1);
    EXPECT_EQ(asTheyAre[0].verdict, Verdict::Worse);
    EXPECT_NEAR(atEqualTime[1].rmseReduction.value, 1, 0.07);
    EXPECT_NE(atEqualTime[0].verdict, Verdict::Worse);
    EXPECT_EQ(atEqualTime[1].rmse.value, asTheyAre[1].rmse.value) << "errors are those of the images";
}

TEST(MeasureBox, IntervalsAreNarrowAndHoldTheirValue) {
    Rng rng(SeedOf(FullTestName()));
    const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 64);
    const BoxResult r = Against(a, b, ExactReference());
    for (const Interval& i : {r.rmse, r.rmseReduction}) {
        EXPECT_TRUE(Holds(i, i.value));
        EXPECT_LT(i.high, 1.3 * i.low);
    }
    for (const Interval& i : {r.relativeMse, r.timeReduction}) {
        EXPECT_TRUE(Holds(i, i.value));
        EXPECT_LT(i.high, Sqr(1.3) * i.low);
    }
    EXPECT_NEAR(r.rmseReduction.value, 2, 0.15);
    EXPECT_DOUBLE_EQ(r.timeReduction.value, r.rmseReduction.value * r.rmseReduction.value);
}

TEST(MeasureBox, TheBaselineIsOneExactly) {
    Rng rng(SeedOf(FullTestName()));
    const Group a = MakeGroup(rng, 3, 16), b = MakeGroup(rng, 3, 16);
    const auto results = MeasureBox(kAll, ExactReference(), {a.Pointers(), b.Pointers()}, 1, 1);
    EXPECT_EQ(results[1].rmseReduction.value, 1);
    EXPECT_EQ(results[1].rmseReduction.low, 1);
    EXPECT_EQ(results[1].rmseReduction.high, 1);
}

TEST(MeasureBox, NobodyIsBestWhereSomebodyIsUntested) {
    // The reference is one of 100 samples: a seventh of the squared error of runs with 16, most of that of
    // runs with 1600, which have the least error, and of which nothing can be said.
    Rng rng(SeedOf(FullTestName()));
    const Group noisy = MakeGroup(rng, 4, 16), noisier = MakeGroup(rng, 4, 4),
                clean = MakeGroup(rng, 4, 1600);
    std::vector<Image> parts;
    for (int i = 0; i < 8; ++i) parts.push_back(MakeRun(rng, 100. / 8));
    const Reference reference = ReferenceOfParts(parts);
    const auto results =
        MeasureBox(kAll, reference, {noisy.Pointers(), noisier.Pointers(), clean.Pointers()}, 0, 1);
    EXPECT_EQ(results[2].verdict, Verdict::Untested);
    EXPECT_EQ(results[0].verdict, Verdict::Untested);
    // Of the others the loser loses all the same.
    EXPECT_EQ(results[1].verdict, Verdict::Worse);
    // The control: without the one that is untested there is a best.
    EXPECT_EQ(MeasureBox(kAll, reference, {noisy.Pointers(), noisier.Pointers()}, 0, 1)[0].verdict,
              Verdict::Best);
}

TEST(MeasureBox, RmseIsTheMeanOverPixelsOfTheRootOverRuns) {
    // Two pixels, two runs; errors (3, 4) and (0, 2) in all channels.
    Reference reference;
    reference.image = Image({2, 1}, {"R", "G", "B"});
    Group group;
    for (const auto& [first, second] : {std::pair(3.f, 0.f), std::pair(-4.f, 2.f)}) {
        Image image({2, 1}, {"R", "G", "B"});
        for (int c = 0; c < 3; ++c) {
            image.Set({0, 0}, c, first);
            image.Set({1, 0}, c, second);
        }
        group.images.push_back(image);
    }
    const auto r = MeasureBox({{0, 0}, {2, 1}}, reference, {group.Pointers()}, 0, 1)[0];
    EXPECT_NEAR(r.rmse.value, (std::sqrt((9. + 16) / 2) + std::sqrt((0. + 4) / 2)) / 2, 1e-6);
    EXPECT_NEAR(r.relativeMse.value, (9. + 16 + 0 + 4) / 4 / 0.01, 1e-3);
}

TEST(MeasureBox, BiasOfOnePercentIsFound) {
    const Reference reference = ExactReference();
    int suspects = 0;
    for (int repetition = 0; repetition < 40; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        const Group honest = MakeGroup(rng, 4, 100), biased = MakeGroup(rng, 4, 100, 1.01);
        // The luminance of 576 pixels and 4 runs with relative noise of 1/10 is known to 0.17 %: 1 % are six
        // of those, and to find fewer than 3.5 is rare (0.6 %).
        const BoxResult found = Against(honest, biased, reference);
        suspects += std::abs(found.bias->Z()) > 3.5;
        EXPECT_NEAR(found.bias->relative, 0.01, 0.01);
        // Beyond 4.5 standard errors: once in 150,000.
        EXPECT_LT(std::abs(Against(biased, honest, reference).bias->Z()), 4.5);
    }
    EXPECT_GE(suspects, 37);
}

TEST(MeasureBox, StandardErrorsAreRight) {
    const Reference reference = ExactReference();
    double squares = 0;
    constexpr int kRepetitions = 200;
    for (int repetition = 0; repetition < kRepetitions; ++repetition) {
        Rng rng(Hash(SeedOf(FullTestName()), repetition));
        const Group group = MakeGroup(rng, 3, 16);
        squares += Sqr(Against(group, group, reference).bias->Z());
    }
    // Mean of 200 squares of unit normals: 1 with a standard error of 0.1.
    EXPECT_NEAR(squares / kRepetitions, 1, 0.45);
}

TEST(MeasureBox, OneRunHasNoBiasButARatio) {
    Rng rng(SeedOf(FullTestName()));
    const BoxResult r = Against(MakeGroup(rng, 1, 16), MakeGroup(rng, 1, 64), ExactReference());
    EXPECT_FALSE(r.bias.has_value());
    EXPECT_NEAR(r.rmseReduction.value, 2, 0.2);
    EXPECT_LT(r.rmseReduction.low, r.rmseReduction.value);
}

TEST(MeasureBox, NoErrorAtAllIsNoNumber) {
    const Reference reference = ExactReference();
    Rng rng(SeedOf(FullTestName()));
    Group exact;
    exact.images = {reference.image, reference.image};
    const BoxResult r = Against(MakeGroup(rng, 2, 16), exact, reference);
    EXPECT_EQ(r.rmse.value, 0);
    EXPECT_TRUE(std::isnan(r.rmseReduction.value));
}

/// A reference with noise of `samples` samples, in parts or as a file whose noise nobody knows.
Reference NoisyReference(Rng& rng, double samples, bool isKnown) {
    constexpr int kParts = 8;
    const Group parts = MakeGroup(rng, kParts, samples / kParts);
    Reference reference = ReferenceOfParts(parts.images);
    if (isKnown) return reference;
    Image plain({kSide, kSide}, {"R", "G", "B"});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c) plain.Set({x, y}, c, reference.image.Get({x, y}, c));
    reference.image = plain;
    return reference;
}

TEST(MeasureBox, NoiseOfTheReferenceIsTakenOut) {
    for (const bool isKnown : {true, false}) {
        Rng rng(Hash(SeedOf(FullTestName()), isKnown));
        const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 64);
        const Reference exact = ExactReference(), noisy = NoisyReference(rng, 128, isKnown);
        EXPECT_EQ(noisy.NoiseIsKnown(), isKnown);
        const BoxResult should = Against(a, b, exact), is = Against(a, b, noisy);
        EXPECT_NEAR(should.rmseReduction.value, 2, 0.1);
        // A third of b's squared error is the reference's.
        EXPECT_NEAR(is.referenceNoiseShare, 1 / 3., 0.05) << isKnown;
        EXPECT_NEAR(is.rmseCorrected, should.rmseCorrected, 0.05 * should.rmseCorrected) << isKnown;
        EXPECT_NEAR(is.rmseReduction.value, should.rmseReduction.value, 0.1) << isKnown;
        EXPECT_GT(is.rmse.value, 1.15 * should.rmse.value) << "the control: uncorrected, it is wrong";
        // And the noise is no bias.
        EXPECT_LT(std::abs(is.bias->Z()), 4.5);
    }
}

TEST(MeasureBox, AReferenceOfMoreNoiseThanTheRunsGivesNoRatio) {
    for (const bool isKnown : {true, false}) {
        Rng rng(Hash(SeedOf(FullTestName()), isKnown));
        const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 64);
        const BoxResult r = Against(a, b, NoisyReference(rng, 32, isKnown));
        EXPECT_GT(r.referenceNoiseShare, 0.5);
        EXPECT_TRUE(std::isnan(r.rmseCorrected));
        EXPECT_TRUE(std::isnan(r.rmseReduction.value));
    }
}

// The bias of one estimator must not be taken for noise of the reference, and so away from the others.
TEST(MeasureBox, OneBiasedEstimatorLeavesTheOthersAlone) {
    Rng rng(SeedOf(FullTestName()));
    const Group a = MakeGroup(rng, 4, 16), biased = MakeGroup(rng, 4, 16, 1.5), b = MakeGroup(rng, 4, 64);
    const auto results =
        MeasureBox(kAll, ExactReference(), {a.Pointers(), biased.Pointers(), b.Pointers()}, 0, 1);
    EXPECT_LT(results[0].referenceNoiseShare, 0.05);
    EXPECT_NEAR(results[2].rmseReduction.value, 2, 0.15);
    EXPECT_GT(results[1].bias->Z(), 10);
}

TEST(MeasureBox, BiasIsFoundAgainstNoisyReferencesToo) {
    for (const bool isKnown : {true, false}) {
        Rng rng(Hash(SeedOf(FullTestName()), isKnown));
        const Reference noisy = NoisyReference(rng, 1024, isKnown);
        const Group honest = MakeGroup(rng, 4, 256), biased = MakeGroup(rng, 4, 256, 1.02);
        EXPECT_GT(Against(honest, biased, noisy).bias->Z(), 3.5) << isKnown;
        EXPECT_LT(std::abs(Against(biased, honest, noisy).bias->Z()), 3.5) << isKnown;
    }
}

TEST(MeasureBox, SeedsMakeIntervalsRepeatable) {
    Rng rng(SeedOf(FullTestName()));
    const Group a = MakeGroup(rng, 4, 16), b = MakeGroup(rng, 4, 16);
    EXPECT_EQ(Against(a, b, ExactReference(), 7).rmse.low, Against(a, b, ExactReference(), 7).rmse.low);
    EXPECT_NE(Against(a, b, ExactReference(), 7).rmse.low, Against(a, b, ExactReference(), 8).rmse.low);
}

TEST(ReferenceOfParts, IsTheMeanAndKnowsItsVariance) {
    Rng rng(SeedOf(FullTestName()));
    const Group parts = MakeGroup(rng, 8, 32);
    const Reference reference = ReferenceOfParts(parts.images);
    double measured = 0, expected = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            double mean = 0;
            for (const Image& part : parts.images) mean += double(part.Get({x, y}, 1)) / 8;
            ASSERT_NEAR(reference.image.Get({x, y}, 1), mean, 1e-5);
            measured += double(reference.image.Get({x, y}, reference.image.FindChannel("MeanVariance.G")));
            expected += Sqr(Truth(x, y, 1)) / 32 / 8;
        }
    // 576 variances of 7 degrees of freedom, of skewed values: known to 3 %.
    EXPECT_NEAR(measured / expected, 1, 0.12);
}

TEST(KeepWholeRounds, CutsToTheRunsThatAllHave) {
    Rng rng(SeedOf(FullTestName()));
    std::vector<CandidateResult> results(2);
    for (size_t i = 0; i < 2; ++i) {
        results[i].images = MakeGroup(rng, 3 - int(i), 16).images;
        results[i].records.resize(3 - i);
        results[i].stages = {{1, 3 - int(i), 0, {}}, {2, 1, 0, {}}};
    }
    KeepWholeRounds(&results);
    for (const CandidateResult& r : results) {
        EXPECT_EQ(r.images.size(), 2u);
        EXPECT_EQ(r.records.size(), 2u);
        EXPECT_EQ(r.stages.size(), 1u);  // what a single run reached says nothing about two
    }
    results[1].images.clear();
    KeepWholeRounds(&results);
    EXPECT_EQ(results.size(), 1u);
}

}  // namespace
}  // namespace lacquer::compare::box_statistics_test
