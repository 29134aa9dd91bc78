#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "estimate/analytic_simulator.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/hmc.h"
#include "estimate/infer/mala.h"
#include "estimate/known_targets.h"
#include "estimate/output/chain_files.h"
#include "estimate/output/checkpoint.h"
#include "estimate/output/predictive_check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::test::output_test {
namespace {

using namespace estimate;

TEST(Checkpoint, ChainsGoOnWithTheSameBits) {
    const NormalTarget target = CorrelatedNormal();
    const Mala mala(3, 60);
    const Hmc hmc(3, 60, {});
    const PublishedMala published(3, 0.02);
    for (const Sampler* sampler : std::initializer_list<const Sampler*>{&mala, &hmc, &published}) {
        std::vector<ChainState> whole(2, sampler->Start(target, Vector::Zero(2))), parts = whole;
        const auto expected = RunChains(*sampler, target, 120, &whole);
        // Stopped in the middle of warm-up, written, read, and gone on with.
        Checkpoint saved{
            .settings = "seed 3", .states = {}, .draws = RunChains(*sampler, target, 37, &parts)};
        saved.states = parts;
        Checkpoint read = ParseCheckpoint(CheckpointText(saved), "checkpoint.json", "seed 3");
        const auto rest = RunChains(*sampler, target, 120, &read.states);
        for (size_t c = 0; c < 2; ++c) {
            read.draws[c].insert(read.draws[c].end(), rest[c].begin(), rest[c].end());
            ASSERT_EQ(read.draws[c].size(), expected[c].size());
            for (size_t i = 0; i < 120; ++i) {
                ASSERT_EQ(read.draws[c][i].y, expected[c][i].y) << i;
                ASSERT_EQ(read.draws[c][i].energy, expected[c][i].energy) << i;
                ASSERT_EQ(read.draws[c][i].isAccepted, expected[c][i].isAccepted) << i;
            }
        }
    }
}

TEST(Checkpoint, DamageAndOtherSettingsAreNamed) {
    const auto messageOf = [](const std::string& text) -> std::string {
        try {
            ParseCheckpoint(text, "checkpoint.json", "seed 1");
        } catch (const FileError& error) {
            return error.what();
        }
        return "";
    };
    const std::string good = CheckpointText({.settings = "seed 1", .states = {ChainState{}}, .draws = {}});
    EXPECT_EQ(messageOf(good), "");
    EXPECT_NE(
        messageOf(CheckpointText({.settings = "seed 2", .states = {}, .draws = {}})).find("other settings"),
        std::string::npos);
    // Torn anywhere, it is refused and nothing else happens.
    for (size_t length = 0; length + 2 < good.size(); length += 7)
        EXPECT_NE(messageOf(good.substr(0, length)).find("damaged"), std::string::npos) << length;
    // So it is with another digit, which would else be another number.
    size_t changed = 0;
    for (size_t i = 0; i < good.size(); ++i) {
        if (good[i] < '0' || good[i] > '9') continue;
        std::string other = good;
        other[i] = good[i] == '9' ? '8' : char(good[i] + 1);
        EXPECT_NE(messageOf(other), "") << i;
        ++changed;
    }
    EXPECT_GT(changed, 20u);
    EXPECT_NE(messageOf("{\"lacquer_checkpoint\": 9}").find("version"), std::string::npos);
    EXPECT_NE(messageOf("[1, 2]").find("damaged"), std::string::npos);
}

TEST(ChainFiles, StanCsvKeepsEveryDigit) {
    const AnalyticSimulator simulator(0, 0);
    const NormalTarget target = CorrelatedNormal();
    const Hmc hmc(5, 20, {});
    std::vector<ChainState> states = {hmc.Start(target, Vector::Zero(2))};
    const std::vector<Draw> draws = RunChains(hmc, target, 50, &states)[0];
    for (const bool savesWarmup : {false, true}) {
        const ChainHeader header{"leather", {{"seed", "5"}}, 20, savesWarmup};
        const std::vector<Draw> shown(draws.begin() + (savesWarmup ? 0 : 20), draws.end());
        std::istringstream text(StanCsv(simulator.Parameters(), header, states[0], shown));
        std::vector<std::vector<double>> rows;
        size_t adaptationAfter = 0;
        std::string names;
        for (std::string line; std::getline(text, line);) {
            if (line == "# Adaptation terminated") adaptationAfter = rows.size();
            if (line[0] == '#') continue;
            if (names.empty()) {
                names = line;
                continue;
            }
            rows.emplace_back();
            std::istringstream cells(line);
            for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
        }
        EXPECT_EQ(names, "lp__,accept_stat__,stepsize__,n_leapfrog__,divergent__,energy__,a,b");
        EXPECT_EQ(adaptationAfter, savesWarmup ? 20u : 0u);
        ASSERT_EQ(rows.size(), shown.size());
        for (size_t i = 0; i < rows.size(); ++i) {
            ASSERT_EQ(rows[i].size(), 8u);
            EXPECT_EQ(rows[i][0], shown[i].logDensity);
            EXPECT_EQ(rows[i][5], shown[i].energy);
            EXPECT_EQ(rows[i][7], simulator.Parameters().ToNatural(shown[i].y)[1]);
        }
    }
}

TEST(ChainFiles, ArviZJsonHasItsGroups) {
    const AnalyticSimulator simulator(0, 0);
    InferenceData data;
    for (int c = 0; c < 3; ++c) data.chains.push_back(std::vector<Draw>(5, Draw{.y = Eigen::Vector2d(0, 1)}));
    data.chains[1][2].logDensity = std::nan("");
    data.priorDraws = Matrix::Zero(2, 7);
    data.summaryNames = simulator.SummaryNames();
    data.observed = Vector::Zero(6);
    data.predictive = Matrix::Zero(4, 6);
    data.attributes = {{"model", "leather"}};
    const auto json = nlohmann::json::parse(ArviZJson(simulator.Parameters(), data));
    EXPECT_EQ(json["posterior"]["b"].size(), 3u);
    EXPECT_EQ(json["posterior"]["b"][0].size(), 5u);
    EXPECT_EQ(double(json["posterior"]["a"][2][4]), 0.5);
    EXPECT_TRUE(json["sample_stats"]["lp"][1][2].is_null());
    EXPECT_EQ(json["prior"]["a"][0].size(), 7u);
    EXPECT_EQ(json["posterior_predictive"]["summary"][0][3].size(), 6u);
    EXPECT_EQ(json["attrs"]["model"], "leather");
}

TEST(PredictiveCheck, RanksAreUniformForTheModelAndSmallForAnotherOne) {
    const ThreadLimit limit(1);  // runs of microseconds
    const AnalyticSimulator simulator(0.1, 0);
    const Vector truth = Eigen::Vector2d(0.4, 5), y = simulator.Parameters().ToLogit(truth);
    const Matrix draws = y.replicate(1, 49);
    RunningMean small;
    for (uint64_t i = 0; i < 200; ++i) {
        const Vector observed = simulator.Simulate(truth, Hash(SeedOf("observed"), i));
        const Matrix predicted = RunSimulator(simulator, draws, i).summaries;
        for (const PredictiveCheck& check : CheckPredictions(simulator.SummaryNames(), predicted, observed))
            small.Add(check.pValue <= 0.2 + 1e-9);
    }
    // A fifth of all; neighbours share half of their variance, so that 1200 count as 600: sd .016.
    EXPECT_NEAR(small.Mean(), 0.2, 0.065);
    Vector odd = simulator.Simulate(truth, 3);
    odd[4] += 10 * simulator.Sd(y);
    const std::vector<PredictiveCheck> checks =
        CheckPredictions(simulator.SummaryNames(), RunSimulator(simulator, draws, 1).summaries, odd);
    EXPECT_EQ(checks[4].summary, "summary 4");
    EXPECT_EQ(checks[4].shareAbove, 0);
    EXPECT_NEAR(checks[4].pValue, 2 / 50., 1e-12);
    EXPECT_GT(checks[4].Residual(), 6);
}

}  // namespace
}  // namespace lacquer::test::output_test
