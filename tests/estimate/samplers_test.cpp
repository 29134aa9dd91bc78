#include <gtest/gtest.h>

#include <cmath>

#include "estimate/diagnostics/convergence.h"
#include "estimate/infer/hmc.h"
#include "estimate/infer/mala.h"
#include "estimate/infer/mixed_chain.h"
#include "estimate/infer/population.h"
#include "estimate/known_targets.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::test::samplers_test {
namespace {

using namespace estimate;
using estimate::Sampler;  // not that of numbers in pixels
using Chains = std::vector<std::vector<Draw>>;

std::vector<ChainState> StartsOf(const Sampler& sampler, const Target& target, size_t count, double spread) {
    Random random(SeedOf("starts"));
    std::vector<ChainState> states;
    for (size_t i = 0; i < count; ++i) {
        Vector y(target.Size());
        for (double& value : y) value = spread * (2 * random.Uniform() - 1);
        states.push_back(sampler.Start(target, y));
    }
    return states;
}

/// The first coordinate of draws from `first` on.
std::vector<double> Pooled(const Chains& chains, size_t first, bool acceptedOnly = false) {
    std::vector<double> values;
    for (const auto& chain : chains)
        for (size_t i = first; i < chain.size(); ++i)
            if (chain[i].isAccepted || !acceptedOnly) values.push_back(chain[i].y[0]);
    return values;
}

Matrix CovarianceOf(const Chains& chains, size_t first) {
    Matrix draws(chains[0][0].y.size(), Eigen::Index(chains.size() * (chains[0].size() - first)));
    Eigen::Index column = 0;
    for (const auto& chain : chains)
        for (size_t i = first; i < chain.size(); ++i) draws.col(column++) = chain[i].y;
    return CovarianceOfColumns(draws);
}

double MeanAcceptance(const Chains& chains, size_t first, size_t last) {
    RunningMean mean;
    for (const auto& chain : chains)
        for (size_t i = first; i < last; ++i) mean.Add(chain[i].acceptStat);
    return mean.Mean();
}

/// Distance from the truth, and of what the published rule gives at the same length.
TEST(Samplers, FiveModesAreSampledToOnePerCent) {
    // 4 million draws in 40 bins: independent ones would be off by .0014, Langevin steps of this target are
    // worth a thirtieth each.
    const FiveModes target;
    const auto length = uint64_t(Scaled(44000));
    const Mala mala(SeedOf("five modes"), length / 11);
    std::vector<ChainState> states = StartsOf(mala, target, 100, 0.9);
    const Chains chains = RunChains(mala, target, length, &states);
    EXPECT_LE(FiveModes::TotalVariation(Pooled(chains, length / 11)), length < 44000 ? 0.03 : 0.01);
    EXPECT_NEAR(MeanAcceptance(chains, length / 11, length), Mala::kTargetAcceptance,
                0.1);  // modes differ in width
}

TEST(Samplers, PublishedAdaptationAndAcceptedStatesOnlyMissTheFiveModes) {
    // The negative controls: at a fifth of the length above, where noise is below .02.
    const FiveModes target;
    constexpr uint64_t kLength = 16000;
    const PublishedMala large(SeedOf("published"), 0.1), middle(SeedOf("published"), 0.02);
    std::vector<ChainState> states = StartsOf(large, target, 100, 0.9);
    const Chains chains = RunChains(large, target, kLength, &states);
    EXPECT_GT(FiveModes::TotalVariation(Pooled(chains, kLength / 2, true)), 0.2);
    // The bias by adaptation alone is smaller, and the acceptance goes on falling: the step goes on growing.
    states = StartsOf(middle, target, 100, 0.9);
    const Chains repeats = RunChains(middle, target, kLength, &states);
    EXPECT_GT(FiveModes::TotalVariation(Pooled(repeats, kLength / 2)), 0.025);
    EXPECT_LT(MeanAcceptance(repeats, kLength * 9 / 10, kLength),
              0.93 * MeanAcceptance(repeats, 0, kLength / 10));
    // The frozen rule at the same length.
    const Mala frozen(SeedOf("frozen"), kLength / 2);
    states = StartsOf(frozen, target, 100, 0.9);
    EXPECT_LT(FiveModes::TotalVariation(Pooled(RunChains(frozen, target, kLength, &states), kLength / 2)),
              0.025);
}

void ExpectCorrelatedNormal(const Matrix& covariance) {
    EXPECT_NEAR(covariance(0, 0), 1, 0.02);
    EXPECT_NEAR(covariance(1, 1) / 0.0025, 1, 0.02);
    EXPECT_NEAR(covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)), 0.9, 0.01);
}

TEST(Samplers, MalaSamplesACorrelatedNormalToTwoPerCent) {
    // Effective draws are near a fortieth: 100 chains of 16,000 know variances to sqrt(2 / 40,000) = 0.7 %.
    const NormalTarget target = CorrelatedNormal();
    const Mala mala(SeedOf("correlated"), 4000);
    std::vector<ChainState> states = StartsOf(mala, target, 100, 0.05);
    const Chains chains = RunChains(mala, target, 20000, &states);
    ExpectCorrelatedNormal(CovarianceOf(chains, 4000));
    for (Eigen::Index i : {0, 1}) EXPECT_LT(SplitRhat(CoordinateOf(chains, 4000, i)), 1.01);
}

TEST(Samplers, PublishedAdaptationMissesACorrelatedNormal) {
    const NormalTarget target = CorrelatedNormal();
    const PublishedMala published(SeedOf("correlated"), 0.05);
    std::vector<ChainState> states = StartsOf(published, target, 100, 0.05);
    const Chains chains = RunChains(published, target, 20000, &states);
    const Matrix covariance = CovarianceOf(chains, 10000);
    EXPECT_GT(std::abs(covariance(1, 1) / 0.0025 - 1), 0.05);
}

TEST(Samplers, MalaAfterThePublishedWarmupSamplesACorrelatedNormal) {
    // A step that keeps on growing in the rule above is frozen here. Draws are worth a 125th: 100 chains of
    // 16,000 know variances to 1.2 %.
    const NormalTarget target = CorrelatedNormal();
    const MalaAfterPublished mala(SeedOf("after published"), 4000, 0.005);
    std::vector<ChainState> states = StartsOf(mala, target, 100, 0.05);
    const Chains chains = RunChains(mala, target, 20000, &states);
    const Matrix covariance = CovarianceOf(chains, 4000);
    EXPECT_NEAR(covariance(0, 0), 1, 0.05);
    EXPECT_NEAR(covariance(1, 1) / 0.0025, 1, 0.05);
    for (const auto& chain : chains)
        for (size_t i = 4001; i < chain.size(); ++i) ASSERT_EQ(chain[i].stepSize, chain[4001].stepSize);
}

TEST(Samplers, HmcSamplesACorrelatedNormalToTwoPerCent) {
    const NormalTarget target = CorrelatedNormal();
    const Hmc hmc(SeedOf("correlated"), 1000, {.maxLeapfrog = 16});
    std::vector<ChainState> states = StartsOf(hmc, target, 16, 0.05);
    const Chains chains = RunChains(hmc, target, 11000, &states);
    ExpectCorrelatedNormal(CovarianceOf(chains, 1000));
    EXPECT_NEAR(MeanAcceptance(chains, 1000, 11000), 0.8, 0.1);
    for (const auto& chain : chains)
        for (size_t i = 1000; i < chain.size(); ++i) ASSERT_FALSE(chain[i].isDivergent);
}

TEST(Samplers, HmcInWhitenedCoordinatesFindsFiveScales) {
    // Scales from 1 to .01, not along the axes, in the coordinates of a rough guess at the covariance.
    Matrix mixing(5, 5);
    Random random(SeedOf("mixing"));
    for (double& value : mixing.reshaped()) value = 0.3 * random.Normal();
    const Vector scales = (Vector(5) << 1, 0.3, 0.1, 0.03, 0.01).finished();
    const Matrix root = scales.asDiagonal() * (Matrix::Identity(5, 5) + mixing);
    const Matrix covariance = root * root.transpose();
    const NormalTarget target(Vector::Constant(5, 2), covariance);
    const WhitenedTarget whitened(target, Vector::Constant(5, 2.01), 1.3 * CholeskyFactor(covariance));
    const Hmc hmc(SeedOf("five scales"), 500, {});
    std::vector<ChainState> states = StartsOf(hmc, whitened, 4, 1);
    Chains chains = RunChains(hmc, whitened, 8500, &states);
    for (auto& chain : chains)
        for (Draw& draw : chain) draw.y = whitened.Original(draw.y);
    const Matrix found = CovarianceOf(chains, 500);
    // 32,000 draws, each worth at least half: variances to sqrt(2 / 16,000) = 1.1 %; three of it.
    for (Eigen::Index i = 0; i < 5; ++i) {
        EXPECT_NEAR(found(i, i) / covariance(i, i), 1, 0.034) << i;
        EXPECT_GT(BulkEss(CoordinateOf(chains, 500, i)), 16000) << i;
        EXPECT_LT(SplitRhat(CoordinateOf(chains, 500, i)), 1.005) << i;
    }
}

TEST(Samplers, DivergencesAreReported) {
    // A funnel's neck: scale exp(y0 / 2) falls by e^-15 within the prior of y0.
    class Funnel final : public Target {
        Eigen::Index Size() const override { return 2; }
        double LogDensity(const Vector& y, Vector* gradient) const override {
            const double precision = std::exp(-y[0]);
            if (gradient) {
                *gradient = Vector(2);
                *gradient << -y[0] / 25 - 0.5 + 0.5 * precision * y[1] * y[1], -precision * y[1];
            }
            return -y[0] * y[0] / 50 - 0.5 * y[0] - 0.5 * precision * y[1] * y[1];
        }
    };
    const Funnel target;
    const Hmc hmc(SeedOf("funnel"), 500, {.maxLeapfrog = 32});
    std::vector<ChainState> states = StartsOf(hmc, target, 8, 1);
    size_t divergent = 0;
    for (const auto& chain : RunChains(hmc, target, 4000, &states))
        for (const Draw& draw : chain) divergent += draw.isDivergent;
    EXPECT_GT(divergent, 0);
}

TEST(Samplers, PopulationsSampleACorrelatedNormalToTwoPerCent) {
    const NormalTarget target = CorrelatedNormal();
    const PopulationWalk walk({.seed = SeedOf("population")});
    Random random(SeedOf("population starts"));
    Matrix starts(2, 80);
    for (double& value : starts.reshaped()) value = random.Normal();
    PopulationState state = walk.Start(target, starts);
    walk.Warmup(target, &state);
    const PopulationDraws draws = walk.Sample(target, 6000, &state);
    ExpectCorrelatedNormal(CovarianceOfColumns(draws.y));
    EXPECT_NEAR(state.acceptance, 0.25, 0.1);
    for (Eigen::Index i : {0, 1}) EXPECT_LT(SplitRhat(draws.Coordinate(i)), 1.02);
}

TEST(Samplers, DiscreteKindsGetTheirMasses) {
    // Three kinds: normals of different widths and heights; the mass of each is height times width.
    // Overlapping, so that the kind can change at all. One coordinate counts as rough.
    const double sds[3] = {1, 0.5, 1.5}, masses[3] = {0.2, 0.5, 0.3};
    std::vector<NormalTarget> targets;
    for (int k = 0; k < 3; ++k) {
        targets.emplace_back(Vector::Constant(2, 0.3 * k), Matrix::Identity(2, 2) * sds[k] * sds[k]);
        targets.back().offset = std::log(masses[k] / (sds[k] * sds[k]));
    }
    const MixedTarget target{{&targets[0], &targets[1], &targets[2]}, {true, false}};
    const MixedChain mixed(SeedOf("kinds"), 2000);
    std::vector<ChainState> states;
    for (uint64_t c = 0; c < 40; ++c) states.push_back(mixed.Start(target, Vector::Zero(2), c % 3));
    const Chains chains = mixed.Run(target, 22000, &states);
    double found[3] = {};
    RunningMean second[3];
    for (const auto& chain : chains)
        for (size_t i = 2000; i < chain.size(); ++i) {
            ++found[chain[i].kind];
            second[chain[i].kind].Add(chain[i].y[1]);
        }
    // Kinds change about once in 40 steps: 20,000 independent kinds, sd .0035; four of it. The widths within
    // a kind are known to the coordinate's own mixing.
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(found[k] / (40 * 20000.), masses[k], 0.014) << k;
        EXPECT_NEAR(std::sqrt(second[k].Variance()) / sds[k], 1, 0.03) << k;
        EXPECT_NEAR(second[k].Mean(), 0.3 * k, 0.05) << k;
    }
}

TEST(Samplers, ThreadsAndInterruptionsDoNotChangeBits) {
    const NormalTarget target = CorrelatedNormal();
    const Mala mala(7, 100);
    const Hmc hmc(7, 100, {});
    const PublishedMala published(7, 0.02);
    for (const Sampler* sampler : std::initializer_list<const Sampler*>{&mala, &hmc, &published}) {
        std::vector<Chains> runs;
        for (const int threads : {1, 2, 7}) {
            const ThreadLimit limit(threads);
            std::vector<ChainState> states = StartsOf(*sampler, target, 5, 0.1);
            // The second run stops in the middle of warm-up and goes on.
            Chains chains;
            if (threads == 2) chains = RunChains(*sampler, target, 57, &states);
            Chains rest = RunChains(*sampler, target, 300, &states);
            if (chains.empty()) chains.resize(rest.size());
            for (size_t c = 0; c < rest.size(); ++c)
                chains[c].insert(chains[c].end(), rest[c].begin(), rest[c].end());
            runs.push_back(std::move(chains));
        }
        for (size_t c = 0; c < 5; ++c)
            for (size_t i = 0; i < 300; ++i) {
                ASSERT_EQ(runs[0][c][i].y, runs[1][c][i].y) << c << " " << i;
                ASSERT_EQ(runs[0][c][i].y, runs[2][c][i].y) << c << " " << i;
            }
    }
}

}  // namespace
}  // namespace lacquer::test::samplers_test
