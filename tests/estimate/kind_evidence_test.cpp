// Kinds by their evidence, and families of summaries by what they tell, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>

#include <Eigen/Dense>

#include "estimate/analytic_simulator.h"
#include "estimate/diagnostics/family_information.h"
#include "estimate/infer/kind_evidence.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::test::kind_evidence_test {
namespace {

using namespace estimate;

/// The logarithm of the integral of the unnormalised posterior over logits.
double LogEvidence(const Target& posterior) {
    double sum = 0;
    for (double a = -6; a <= 6; a += 0.05)
        for (double b = -6; b <= 6; b += 0.05)
            sum += std::exp(posterior.LogDensity(Eigen::Vector2d(a, b), nullptr));
    return std::log(sum);
}

/// Exact draws, by the density on a grid.
Matrix DrawsOf(const Target& posterior, uint64_t seed) {
    constexpr Eigen::Index kDraws = 2000;
    constexpr int kSide = 240;
    std::vector<double> cumulative;
    double sum = 0;
    const auto at = [](int i, int j) { return Eigen::Vector2d(0.05 * i - 6, 0.05 * j - 6); };
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j)
            cumulative.push_back(sum += std::exp(posterior.LogDensity(at(i, j), nullptr)));
    Random random(seed);
    Matrix draws(2, kDraws);
    for (Eigen::Index k = 0; k < kDraws; ++k) {
        const auto found = std::lower_bound(cumulative.begin(), cumulative.end(), sum * random.Uniform());
        const int place = int(found - cumulative.begin());
        draws.col(k) = at(place / kSide, place % kSide);
    }
    return draws;
}

// Two kinds that differ in how summaries bend. Each photograph is of one of them, with parameters of the
// prior.
TEST(KindProbabilitiesLong, AreThoseOfTheExactEvidence) {
    const ThreadLimit limit(1);  // runs of microseconds
    const AnalyticSimulator straight(0, 0), bent(0.8, 0);
    RunningMean error, ofTruth;
    int numClear = 0, numRight = 0;
    for (uint64_t i = 0; i < 40; ++i) {
        Random random(SeedOf("kinds"), i);
        const AnalyticSimulator& truth = i % 2 ? bent : straight;
        const Vector x = truth.Parameters().SamplePrior(random);
        const Vector observed = truth.Simulate(x, random.Bits());
        const AnalyticPosterior first(straight, observed), second(bent, observed);
        const double exact = 1 / (1 + std::exp(LogEvidence(first) - LogEvidence(second)));
        const std::vector<double> found = KindProbabilities(
            {{&straight, DrawsOf(first, i)}, {&bent, DrawsOf(second, i)}}, observed, 300, i);
        EXPECT_NEAR(found[0] + found[1], 1, 1e-12);
        error.Add(std::abs(found[1] - exact));
        ofTruth.Add(found[i % 2]);
        numClear += std::max(exact, 1 - exact) > 0.9;
        numRight += std::max(exact, 1 - exact) > 0.9 && (found[1] > 0.5) == (exact > 0.5);
    }
    // What is taken for normal here is not quite: by 0.06, which is known to 0.01.
    EXPECT_LT(error.Mean(), 0.08);
    // Where the exact one is sure, so is this; and the photographs do tell.
    EXPECT_GE(numClear, 10);
    EXPECT_EQ(numRight, numClear);
    EXPECT_GT(ofTruth.Mean(), 0.65);
}

/// One summary more, which depends on the kind alone: normal about `mark`.
class Marked final : public Simulator {
  public:
    explicit Marked(double mark) : mark_(mark), names_(simulator_.SummaryNames()) {
        names_.emplace_back("mark");
    }
    const ParameterSpace& Parameters() const override { return simulator_.Parameters(); }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override {
        Vector summaries(Eigen::Index(names_.size()));
        summaries << simulator_.Simulate(x, seed), mark_ + Random(seed, 1).Normal();
        return summaries;
    }

  private:
    AnalyticSimulator simulator_{0, 0};
    double mark_;
    std::vector<std::string> names_;
};

// What tells kinds apart need not tell anything of a parameter: regressions on the parameters alone would
// leave 1/2 here. The odds are those of two normal distributions.
TEST(KindProbabilities, CountWhatTellsNoParameter) {
    const ThreadLimit limit(1);
    const Marked low(-1), high(1);
    int numFar = 0;
    for (const double mark : {-1.2, -0.3, 0., 0.5, 1.}) {
        std::vector<double> errors;
        for (uint64_t i = 0; i < 8; ++i) {
            Vector observed(AnalyticSimulator::kCount + 1);
            Random random(SeedOf("marks"), mark, i);
            const AnalyticSimulator simulator(0, 0);
            const Vector x = simulator.Parameters().SamplePrior(random);
            const Vector six = simulator.Simulate(x, random.Bits());
            observed << six, mark;
            const Matrix draws = DrawsOf(AnalyticPosterior(simulator, six), i);
            const std::vector<double> found =
                KindProbabilities({{&low, draws}, {&high, draws}}, observed, 1000, SeedOf("kinds") + i);
            errors.push_back(found[1] - 1 / (1 + std::exp(-2 * mark)));
            numFar += std::abs(errors.back()) > 0.1;
        }
        // 1000 simulations know a mark's mean to 0.03, its deviation to 0.02, and their regression to as
        // much where the other six are as usual; of six in the tails it knows less.
        std::sort(errors.begin(), errors.end());
        EXPECT_NEAR((errors[3] + errors[4]) / 2, 0, 0.03) << mark;
    }
    EXPECT_LE(numFar, 4);
}

TEST(KindProbabilities, ASingleKindHasAllOfIt) {
    const AnalyticSimulator simulator(0, 0);
    EXPECT_EQ(KindProbabilities({{&simulator, Matrix::Zero(2, 3)}}, Vector::Zero(6), 10, 1),
              std::vector<double>{1});
}

// Linear summaries with known covariance: the information is J^T C^-1 J.
TEST(PredictedDeviations, AreThoseOfTheClosedForm) {
    const ThreadLimit limit(1);
    const AnalyticSimulator simulator(0, 0);
    const ParameterSpace& space = simulator.Parameters();
    const Vector y = Eigen::Vector2d(0.3, -0.2);
    Matrix jacobian(6, 2), prior(2, 4000);
    for (Eigen::Index i = 0; i < 2; ++i)
        jacobian.col(i) = simulator.Mean(y + Vector::Unit(2, i)) - simulator.Mean(y);
    for (Eigen::Index k = 0; k < prior.cols(); ++k) {
        Random random(SeedOf("prior"), uint64_t(k));
        prior.col(k) = space.ToLogit(space.SamplePrior(random));
    }
    const Vector variances =
        (prior.colwise() - prior.rowwise().mean()).rowwise().squaredNorm() / double(prior.cols());
    const std::vector<FamilyRange> families = {{"first", 0, 1}, {"rest", 1, 5}};
    const Matrix found = PredictedDeviations(simulator, families, y, 2000, SeedOf("runs"));
    ASSERT_EQ(found.rows(), 3);
    const Matrix covariance = simulator.Sd(y) * simulator.Sd(y) * AnalyticSimulator::Correlations();
    for (const auto& [row, first, count] : {std::tuple(0, 0, 1), {1, 1, 5}, {2, 0, 6}}) {
        const Matrix part = jacobian.middleRows(first, count);
        Matrix information =
            part.transpose() * covariance.block(first, first, count, count).llt().solve(part);
        information.diagonal() += variances.cwiseInverse();
        const Matrix expected = information.inverse();
        for (Eigen::Index i = 0; i < 2; ++i)
            EXPECT_NEAR(found(row, i), std::sqrt(expected(i, i) / variances[i]), 0.05) << row << " " << i;
    }
    EXPECT_LT(found(2, 0), found(0, 0));
}

}  // namespace
}  // namespace lacquer::test::kind_evidence_test
