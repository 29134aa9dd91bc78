// The fit of lobes, part by part, and against the tables in the repository.
#include "gaussfit/fit/lobe_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussfit/fit/polynomial_fit.h"

namespace lacquer::gaussfit::lobe_fit_test {
namespace {

/// A slice that is a mixture: masses of cells over a box wide enough for it.
Slice SliceOf(const SliceMixture& mixture, double x0, double x1, double y1) {
    Slice slice{x0, x1, y1, 160, 80, {}, 1};
    double sum = 0;
    for (int row = 0; row < slice.rows; ++row)
        for (int column = 0; column < slice.columns; ++column) {
            slice.mass.push_back(float(mixture.Pdf(slice.X(column), slice.Y(row))));
            sum += double(slice.mass.back());
        }
    for (float& mass : slice.mass) mass = float(double(mass) / sum);
    return slice;
}

TEST(SliceMixture, FindsTheMixtureThatASliceIs) {
    SliceMixture truth;
    truth.count = 2;
    truth.parts[0] = {0.6, 1.0, 0.04, 0.02};
    truth.parts[1] = {0.4, 1.3, 0.3, 0.25};
    const SliceMixture found = FitSlice(SliceOf(truth, -2.5, 5, 4), 2, 400);
    for (size_t i = 0; i < 2; ++i) {
        // Cells are 0.047 and 0.05 wide: their spread adds 2e-4 to each variance, 1 % of the smallest.
        EXPECT_NEAR(found.parts[i].weight, truth.parts[i].weight, 0.01);
        EXPECT_NEAR(found.parts[i].meanX, truth.parts[i].meanX, 0.01);
        EXPECT_NEAR(found.parts[i].varianceX / truth.parts[i].varianceX, 1, 0.03);
        EXPECT_NEAR(found.parts[i].varianceY / truth.parts[i].varianceY, 1, 0.03);
    }
}

TEST(SliceMixture, OverlapAndLikelihoodAreLargestAtTheTruth) {
    SliceMixture truth;
    truth.parts[0] = {1, 1.0, 0.04, 0.02};
    const Slice slice = SliceOf(truth, 0, 2, 1);
    EXPECT_NEAR(Overlap(slice, truth), 1, 1e-3);
    SliceMixture wrong = truth;
    wrong.parts[0].meanX += 0.1;  // half a standard deviation
    // Two Gaussians d standard deviations apart share 2 Phi(-d/2), and log-likelihood d^2/2 is lost.
    EXPECT_NEAR(Overlap(slice, wrong), std::erfc(0.25 / std::sqrt(2.0)), 2e-3);
    EXPECT_NEAR(LogLikelihood(slice, truth) - LogLikelihood(slice, wrong), 0.125, 1e-3);
}

TEST(PolynomialFit, FindsControlValuesAndKeepsBounds) {
    BasisMatrix basis;
    basis.columns = 5;
    PolynomialFitProblem problem;
    problem.basis = &basis;
    const double truth[] = {1, 3, 0.5, 2, 4};
    for (int i = 0; i <= 40; ++i) {
        const auto values = BernsteinBasis<4>(i / 40.0);
        double sum = 0;
        for (size_t k = 0; k < 5; ++k) {
            basis.values.push_back(values[k]);
            sum += values[k] * truth[k];
        }
        problem.targets.push_back(std::log(sum));
        problem.weights.push_back(1);
    }
    problem.isLogarithmic = true;
    problem.lower = 1e-4;
    std::vector<double> control(5, 1.0);
    FitPolynomial(problem, &control);
    for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(control[k], truth[k], 1e-3) << k;

    problem.lower = 0.8;
    problem.upper = 3.5;
    FitPolynomial(problem, &control);
    for (const double value : control) {
        EXPECT_GE(value, 0.8);
        EXPECT_LE(value, 3.5);
    }
    EXPECT_NEAR(control[2], 0.8, 1e-6);
}

TEST(LobeSlice, OfSmallRoughnessIsTheLinearisedLobe) {
    // The factors of all models tend to 1: at alpha = 0.005 and moderate angles they are within 1 %. Beckmann
    // only: the tails of GGX have no second moment to speak of.
    for (const LobeModel& model : LobeModels()) {
        if (model.distribution != MicrofacetModel::Beckmann) continue;
        const LobeFitOptions options;
        const SlicePoint point = PointAt(model, options, 0, 0.5, 0, 0.3);
        const SliceMoments moments = MomentsOf(TabulateSlice(model, point, {}));
        const LobeBasis<double> basis =
            LobeBasisOf<double>(model.event, {point.alpha, point.eta, std::cos(point.theta)});
        EXPECT_NEAR(basis.shape.mean, SpecularSlope(model, point), 0.01 * std::abs(basis.shape.mean))
            << model.name;
        EXPECT_NEAR(moments.meanX, SpecularSlope(model, point), 0.05 * std::sqrt(moments.varianceX))
            << model.name;
        EXPECT_NEAR(std::sqrt(moments.varianceX) * basis.shape.l11, 1, 0.01) << model.name;
        EXPECT_NEAR(std::sqrt(moments.varianceY) * basis.shape.l22, 1, 0.01) << model.name;
    }
}

/// Largest differences of two tables' lobes over a grid: means in standard deviations, and logs of L.
struct TableDifference {
    double mean = 0, logL = 0;
};
TableDifference Compare(const LobeTable& a, const LobeTable& b, const LobeFitOptions& options) {
    TableDifference d;
    const LobeModel& model = *a.Get().model;
    for (int patch = 0; patch < 2; ++patch)
        for (int i = 0; i <= 20; ++i)
            for (int j = 0; j <= 20; ++j) {
                const SlicePoint point = PointAt(model, options, patch, 0.5, i / 20.0, j / 20.0);
                const SliceMixture x = MixtureOf(a, point), y = MixtureOf(b, point);
                EXPECT_EQ(x.count, model.numComponents);
                for (size_t k = 0; k < size_t(x.count); ++k) {
                    const SliceGaussian &g = x.parts[k], &h = y.parts[k];
                    d.mean = std::max(d.mean, std::abs(g.meanX - h.meanX) / std::sqrt(g.varianceX));
                    d.logL = std::max({d.logL, std::abs(std::log(g.varianceX / h.varianceX)) / 2,
                                       std::abs(std::log(g.varianceY / h.varianceY)) / 2});
                }
            }
    return d;
}

TEST(LobeFit, GivesTheTableInTheRepositoryAgain) {
    // Other compilers and processors round differently, which fits carry on by far less than this; the
    // tables' own errors are ten times as large.
    constexpr double kTolerance = 1e-3;
    const LobeModel& model = *FindLobeModel("beckmann-reflection");
    const LobeTable* stored = EmbeddedLobeTable(model.distribution, model.event);
    ASSERT_NE(stored, nullptr);
    Observer silent;
    LobeFitOptions options;
    const LobeFitResult fit = FitLobes(model, options, &silent);
    EXPECT_EQ(fit.table.Get().options, stored->Get().options)
        << "the options of data/lobes are not the defaults";
    const TableDifference same = Compare(fit.table, *stored, options);
    EXPECT_LT(same.mean, kTolerance);
    EXPECT_LT(same.logL, kTolerance);

    // Negative control: a truncation at a tenth of the default's cuts off other tails.
    options.slice.truncation *= 10;
    const TableDifference other = Compare(FitLobes(model, options, &silent).table, *stored, options);
    EXPECT_GT(other.mean, kTolerance);
    EXPECT_GT(other.logL, kTolerance);
}

TEST(LobeFit, StopsWhenAsked) {
    struct Impatient final : Observer {
        bool ShouldStop() override { return true; }
    } observer;
    EXPECT_THROW(FitLobes(*FindLobeModel("beckmann-entering"), {}, &observer), FitStopped);
}

}  // namespace
}  // namespace lacquer::gaussfit::lobe_fit_test
