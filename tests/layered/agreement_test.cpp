// All estimators agree with the analog random walk on all stacks of the table.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <mutex>

#include "layered/agreement.h"
#include "pbrt/core/parallel.h"

namespace lacquer::layered::test::agreement_test {

namespace {

struct Task {
    const StackCase* row;
    NamedQuery query;
    std::string Name() const {
        return fmt::format("{}, {} {}", row->name, query.name,
                           query.mode == TransportMode::Radiance ? "radiance" : "importance");
    }
};

std::vector<Task> Tasks() {
    std::vector<Task> tasks;
    for (const StackCase& row : StackCases()) {
        if (!row.isSmall && !AsksForAllStacks()) continue;
        Arena arena;
        for (const NamedQuery& query : QueriesOf(row.Build(arena))) tasks.push_back({&row, query});
    }
    return tasks;
}

/// What each test run examines: estimators that renders use.
std::vector<std::string> UsedEstimators() {
    std::vector<std::string> names = UnbiasedEstimators();
    std::erase_if(names,
                  [](const std::string& name) { return name == "forward" || name == "unidirectional"; });
    return names;
}
/// What the full test examines as well: plain methods to compare others with, whose known answers are looked
/// at each time; products of more events and by more strategies than by default.
std::vector<std::string> OtherEstimators() {
    return {"forward", "unidirectional", "multiproduct:7", "pairproduct:all:99999"};
}
int NumEstimators() { return int(UsedEstimators().size() + OtherEstimators().size()); }

/// Sums over all queries of one estimator.
struct Totals {
    double difference = 0, variance = 0, expected = 0;
    int numTests = 0, numAbove3 = 0, numCoarse = 0, numInvalid = 0;
    double worstError = 0;
    std::string coarsest;

    void Add(const Agreement& a, const std::string& name, double wantedError) {
        difference += a.values.Albedo() - a.walks.Albedo();
        variance += Sqr(a.values.AlbedoError()) + Sqr(a.walks.AlbedoError());
        expected += a.walks.Albedo();
        for (const double z : a.comparison.z) {
            ++numTests;
            numAbove3 += std::abs(z) > 3;
        }
        numInvalid += a.values.NumInvalid();
        const double error = a.values.AlbedoError() / std::max(a.values.Albedo(), 1e-9);
        numCoarse += error > wantedError;
        if (error > worstError) {
            worstError = error;
            coarsest = name;
        }
    }
};

/// What was found about one estimator.
struct Findings {
    Totals totals;
    std::string failures;
};

void ExpectSmallSums(const std::string& estimator, const Findings& found, size_t numQueries, double alpha) {
    const Totals& totals = found.totals;
    EXPECT_EQ(found.failures, "") << estimator << ", each at " << alpha;
    EXPECT_EQ(totals.numInvalid, 0) << estimator;

    // A small bias of all queries shows in their sum.
    const double excess = totals.difference / totals.expected;
    const double error = std::sqrt(totals.variance) / totals.expected;
    EXPECT_GE(NormalTwoSided(excess / error), 1e-3) << fmt::format(
        "{}: sum of albedos off by {:+.3f} % +- {:.3f} %", estimator, 100 * excess, 100 * error);
    const std::string summary = fmt::format(
        "{}: {} means, {} beyond 3 sigma ({:.0f} by chance), sum {:+.3f} % +- {:.3f} %, {} of {} queries "
        "above "
        "0.5 % of standard error, the worst {:.2f} % ({})",
        estimator, totals.numTests, totals.numAbove3, 0.0027 * totals.numTests, 100 * excess, 100 * error,
        totals.numCoarse, numQueries, 100 * totals.worstError, totals.coarsest);
    testing::Test::RecordProperty("summary " + estimator, summary);
    if (AsksForAllStacks()) std::cout << summary << std::endl;
    if (IsFullRun()) {
        EXPECT_EQ(totals.numCoarse, 0) << summary;
    }
}

/// Fails unless the values of estimators have the means of walks. All are compared with the same walks, which
/// would take half of the time: one that strays by chance is walked again, see Examine().
void ExpectMeansOfWalks(const std::vector<std::string>& estimators) {
    const std::vector<Task> tasks = Tasks();
    // Every moment of every query of every estimator is a test of the family.
    const double alpha = SidakAlpha(1e-3, int(tasks.size()) * kNumMoments * NumEstimators());
    std::mutex mutex;
    std::map<std::string, Findings> findings;
    ParallelFor(int64_t(tasks.size()), [&](int64_t i) {
        const Task& task = tasks[size_t(i)];
        Arena arena;
        const Stack stack = task.row->Build(arena);
        const WalkedQuery walked =
            TakeWalks({stack, task.query.wo, task.query.mode}, DefaultEffort().numWalks, SeedOf(task.Name()));
        for (const std::string& estimator : estimators) {
            const LayeredBxDF* bxdf = task.row->MakeBxDF(arena, {.estimator = FindEstimator(estimator)});
            const Agreement a = Examine(walked, ValuesOf(*bxdf, task.query.wo, task.query.mode),
                                        DefaultEffort(), SeedOf(task.Name() + estimator), kSuspicious);
            const std::lock_guard lock(mutex);
            Findings& found = findings[estimator];
            found.totals.Add(a, task.Name(), 0.005);
            if (!(NormalTwoSided(a.WorstZ()) >= alpha))
                found.failures += task.Name() + ": " + a.comparison.Describe(a.values, a.walks) + "\n";
        }
    });
    for (const std::string& estimator : estimators)
        ExpectSmallSums(estimator, findings[estimator], tasks.size(), alpha);
}

TEST(LayeredAgreement, ValuesHaveTheMeansOfWalks) { ExpectMeansOfWalks(UsedEstimators()); }
TEST(LayeredAgreementLong, ValuesOfOthersHaveTheMeansOfWalks) { ExpectMeansOfWalks(OtherEstimators()); }

TEST(LayeredAgreementTable, IsLargeAndItsNamesDiffer) {
    std::vector<std::string> names;
    for (const StackCase& row : StackCases()) names.push_back(row.name);
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    EXPECT_GE(names.size(), 60u);
}

}  // namespace
}  // namespace lacquer::layered::test::agreement_test
