// Markov chains in primary sample space against known densities. Chains that start in the density stay in it,
// whatever the number of steps: the last paths of independent chains are independent draws from it.
#include <gtest/gtest.h>

#include "pbrt/integrators/primary_samples.h"
#include "support/statistics.h"

namespace lacquer::primary_samples_test {
namespace {

using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::Scaled;
using test::SeedOf;

constexpr double kAlpha = 1e-5;
constexpr int kCells = 8;
constexpr int kSteps = 12;

struct Visit {
    Point2 u{0};
    float contribution = 0;
};

/// A narrow ridge that crosses the edge of the unit square, on a low floor with an empty band.
float RidgeAt(Point2 u) {
    const float toEdge = std::min(u.x, 1 - u.x);
    if (u.y > 0.75f && u.y < 0.8f) return 0;
    return 0.2f + 3 * std::exp(-Sqr(toEdge / 0.15f)) * (0.2f + u.y);
}
constexpr float kMaxRidge = 4;

/// How a chain goes on. The last ones are wrong on purpose.
enum class Rule { Right, KeepsRejected, AcceptsAll };

/// How many numbers a path asks for: the second one always, the first one of another stream only where it
/// counts. Numbers that no path asks for miss steps.
struct Target {
    bool skipsNumbers = false;

    Visit operator()(PrimarySamples& samples) const {
        Visit visit;
        samples.StartStream(0);
        visit.u.y = samples.Get1D();
        samples.StartStream(1);
        // Where y is small, x is drawn for nothing but the record: the density does not depend on it.
        if (skipsNumbers && visit.u.y < 0.5f) {
            visit.contribution = 1;
            visit.u.x = -1;
            return visit;
        }
        visit.u.x = samples.Get1D();
        visit.contribution = RidgeAt(visit.u);
        return visit;
    }
};

/// A chain that starts in the density of its target: by rejection.
std::pair<PrimarySamples, Visit> Start(uint64_t seed, const PrimarySamples::Steps& steps,
                                       const Target& target) {
    for (int i = 0;; ++i) {
        PrimarySamples samples(steps);
        samples.StartChain(Hash(seed, i));
        const Visit visit = target(samples);
        if (samples.AcceptanceNumber() * kMaxRidge < visit.contribution) {
            samples.Reseed(Hash(seed, i, 1));
            return {samples, visit};
        }
    }
}

/// The last path of a chain, and what its steps recorded for each cell.
Visit Follow(uint64_t seed, const PrimarySamples::Steps& steps, const Target& target, Rule rule) {
    auto [samples, current] = Start(seed, steps, target);
    if (rule == Rule::Right) {
        PrimarySampleChain<Visit> chain(samples, current);
        for (int i = 0; i < kSteps; ++i) chain.Mutate(target, [](const Visit&, float) {});
        return chain.Current();
    }
    for (int i = 0; i < kSteps; ++i) {
        samples.StartStep();
        const Visit proposed = target(samples);
        const float acceptance = std::min(1.f, proposed.contribution / current.contribution);
        const bool accepts =
            rule == Rule::AcceptsAll ? proposed.contribution > 0 : samples.AcceptanceNumber() < acceptance;
        if (accepts) current = proposed;
        // Where the numbers of rejected paths stay, the next path is compared with one that is not there.
        if (accepts || rule == Rule::KeepsRejected)
            samples.Accept();
        else
            samples.Reject();
    }
    return current;
}

size_t CellOf(Point2 u) {
    const auto index = [](float x) { return size_t(std::clamp(int(x * kCells), 0, kCells - 1)); };
    return index(u.y) * (kCells + 1) + (u.x < 0 ? size_t(kCells) : index(u.x));
}
constexpr size_t kNumCells = size_t(kCells) * (kCells + 1);

/// Probabilities of the cells, by the midpoint rule.
std::vector<double> Expected(const Target& target) {
    constexpr int kFine = 800;
    std::vector<double> cells(kNumCells);
    double sum = 0;
    for (int j = 0; j < kFine; ++j)
        for (int i = 0; i < kFine; ++i) {
            Point2 u((float(i) + 0.5f) / kFine, (float(j) + 0.5f) / kFine);
            double value = double(RidgeAt(u));
            if (target.skipsNumbers && u.y < 0.5f) {
                u.x = -1;
                value = 1;
            }
            cells[CellOf(u)] += value;
            sum += value;
        }
    for (double& cell : cells) cell /= sum;
    return cells;
}

Outcome ComparesTo(const PrimarySamples::Steps& steps, const Target& target, Rule rule, uint64_t seed) {
    const int count = Scaled(40000);
    std::vector<double> observed(kNumCells), expected = Expected(target);
    for (int k = 0; k < count; ++k) ++observed[CellOf(Follow(Hash(seed, k), steps, target, rule).u)];
    for (double& cell : expected) cell *= count;
    return test::ChiSquareTest(observed, expected);
}

const PrimarySamples::Steps kUsual{0.3f, 0.05f}, kSmall{0, 0.1f}, kLarge{1, 0.01f}, kWide{0.1f, 0.6f};

// Power: of 40 000 paths a cell has 60 to 2000, so a cell that is off by a third to a sixteenth, or all cells
// by 4 %, fails. The negative controls have p-values below 1e-30.
TEST(PrimarySampleChain, StaysInADensityOfTwoNumbers) {
    for (const PrimarySamples::Steps& steps : {kUsual, kSmall, kLarge, kWide})
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(steps.sigma), kAlpha,
                           [&](uint64_t seed) { return ComparesTo(steps, {}, Rule::Right, seed); }));
}
TEST(PrimarySampleChain, StaysInADensityOfANumberThatIsNotAlwaysAskedFor) {
    for (const PrimarySamples::Steps& steps : {kUsual, kSmall, kLarge, kWide})
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(steps.sigma), kAlpha,
                           [&](uint64_t seed) { return ComparesTo(steps, {true}, Rule::Right, seed); }));
}
TEST(PrimarySampleChain, NegativeControlWrongRulesLeaveTheDensity) {
    for (const Rule rule : {Rule::KeepsRejected, Rule::AcceptsAll})
        EXPECT_LT(ComparesTo(kUsual, {}, rule, SeedOf(FullTestName())).pValue, 1e-30) << int(rule);
}

/// Sums of what is recorded in the left quarter, over all steps, against their expectation.
Outcome RecordsInTheLeftQuarter(bool forgetsCurrent, uint64_t seed) {
    const int count = Scaled(20000);
    double left = 0, all = 0;
    const std::vector<double> cells = Expected({});
    for (size_t i = 0; i < kNumCells; ++i)
        left += i % (kCells + 1) < kCells / 4 ? cells[i] : 0, all += cells[i];
    test::RunningMean mean;
    for (int k = 0; k < count; ++k) {
        auto [samples, start] = Start(Hash(seed, k), kUsual, {});
        PrimarySampleChain<Visit> chain(samples, start);
        double sum = 0;
        for (int i = 0; i < kSteps; ++i) {
            const Visit before = chain.Current();
            chain.Mutate(Target{}, [&](const Visit& visit, float weight) {
                if (forgetsCurrent && visit.u == before.u) return;
                if (visit.u.x < 0.25f) sum += double(weight * visit.contribution);
            });
        }
        mean.Add(sum / kSteps);
    }
    return test::ZTest(mean, left / all, 1e-4, "the left quarter");
}
// Power: the standard error is 0.2 %.
TEST(PrimarySampleChain, RecordsBothPathsByTheirProbability) {
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [](uint64_t seed) { return RecordsInTheLeftQuarter(false, seed); }));
    EXPECT_LT(RecordsInTheLeftQuarter(true, SeedOf(FullTestName())).pValue, kAlpha);
}

TEST(PrimarySamples, RejectedStepsLeaveNoTrace) {
    PrimarySamples samples(kUsual);
    samples.StartChain(7);
    const auto read = [&] {
        std::vector<float> numbers;
        for (int stream = 0; stream < PrimarySamples::kNumStreams; ++stream) {
            samples.StartStream(stream);
            for (int i = 0; i < 5 - stream; ++i) numbers.push_back(samples.Get1D());
        }
        return numbers;
    };
    std::vector<float> current = read();
    int large = 0;
    for (int step = 0; step < 200; ++step) {
        const uint64_t pathSeed = samples.PathSeed();
        samples.StartStep();
        large += samples.IsLargeStep();
        const std::vector<float> proposed = read();
        EXPECT_NE(proposed, current);
        EXPECT_EQ(proposed, read()) << "a number has one value in a step";
        EXPECT_EQ(samples.PathSeed() != pathSeed, samples.IsLargeStep());
        for (const float u : proposed) EXPECT_TRUE(u >= 0 && u < 1) << u;
        if (step % 3 == 0) {
            samples.Accept();
            current = proposed;
        } else {
            samples.Reject();
            EXPECT_EQ(samples.PathSeed(), pathSeed);
            EXPECT_EQ(read(), current);
        }
    }
    EXPECT_GT(large, 30);
    EXPECT_LT(large, 90);
}

TEST(PrimarySamples, ChainsThatStartAnewKnowNothingOfThoseBefore) {
    const auto read = [](PrimarySamples* samples) {
        std::vector<float> numbers;
        for (int step = 0; step < 20; ++step) {
            for (int i = 0; i < 4; ++i) numbers.push_back(samples->Get1D());
            numbers.push_back(float(samples->PathSeed() >> 40));
            step % 2 == 0 ? samples->Accept() : samples->Reject();
            samples->StartStep();
        }
        return numbers;
    };
    PrimarySamples used(kUsual), fresh(kUsual);
    used.StartChain(3);
    read(&used);
    used.StartChain(5);
    fresh.StartChain(5);
    EXPECT_EQ(read(&used), read(&fresh));
}

// What one stream takes shifts nothing in another.
TEST(PrimarySamples, StreamsAreApart) {
    PrimarySamples samples({0, 0});  // small steps of no length
    samples.StartChain(7);
    samples.StartStream(1);
    const float second = samples.Get1D();
    for (int step = 0; step < 5; ++step) {
        samples.StartStep();
        for (int i = 0; i < step * 10; ++i) samples.Get1D();
        samples.StartStream(1);
        EXPECT_EQ(samples.Get1D(), second);
        samples.Accept();
    }
}

}  // namespace
}  // namespace lacquer::primary_samples_test
