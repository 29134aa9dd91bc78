// Reports of estimates with known content: one where all is well, and one where all is not.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "cmd/estimate/report.h"
#include "cmd/page_checks.h"

namespace lacquer::cmd {

/// An image of rings and grains; with one channel a relief.
inline Image TestPicture(uint32_t seed, int numChannels, float scale = 1) {
    constexpr int kSide = 64;
    std::mt19937 random(seed);
    Image image({kSide, kSide},
                numChannels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const float r = float(std::hypot(x - 0.5 * kSide, y - 0.5 * kSide)) / kSide;
            const float grain = 0.15f * float(random() & 0xffff) / 65536.f;
            for (int c = 0; c < numChannels; ++c)
                image.Set({x, y}, c,
                          scale * std::min(1.f, (1 - 0.2f * float(c)) * std::exp(-4 * r * r) + grain));
        }
    return image;
}

/// Fills what follows from the chains.
inline void Summarise(EstimateParameter* p) {
    std::vector<double> all;
    for (const std::vector<double>& chain : p->chains) all.insert(all.end(), chain.begin(), chain.end());
    std::sort(all.begin(), all.end());
    const auto quantile = [&](double share) { return all[size_t(share * double(all.size() - 1))]; };
    double sum = 0, squares = 0;
    for (const double x : all) sum += x;
    p->mean = sum / double(all.size());
    for (const double x : all) squares += (x - p->mean) * (x - p->mean);
    p->sd = std::sqrt(squares / double(all.size() - 1));
    p->q5 = quantile(0.05), p->q50 = quantile(0.5), p->q95 = quantile(0.95);
    if (p->prior) {
        const double margin = 0.01 * (p->prior->high - p->prior->low);
        const auto share = [&](auto isThere) {
            return double(std::count_if(all.begin(), all.end(), isThere)) / double(all.size());
        };
        p->shareAtLow = share([&](double x) { return x < p->prior->low + margin; });
        p->shareAtHigh = share([&](double x) { return x > p->prior->high - margin; });
    }
}

/// What is wanted of a parameter of a test report.
struct TestParameter {
    const char *name, *meaning, *unit;
    EstimatePrior prior;
    double mean, sd, truth;
};

/// Four chains of 500 draws, each a walk that keeps half of its place; `common` is shared with the other
/// parameters. @param apart  deviations from chain to chain
inline EstimateParameter MakeParameter(const TestParameter& wanted, uint32_t seed,
                                       const std::vector<std::vector<double>>& common, double share,
                                       double apart = 0) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    EstimateParameter p;
    p.name = wanted.name, p.meaning = wanted.meaning, p.unit = wanted.unit;
    p.prior = wanted.prior, p.priorSd = wanted.prior.sd * 0.97;
    p.truth = wanted.truth;
    for (size_t c = 0; c < common.size(); ++c) {
        double t = normal(random);
        p.chains.emplace_back();
        for (const double other : common[c]) {
            t = 0.5 * t + std::sqrt(0.75) * normal(random);
            const double z = share * other + std::sqrt(1 - share * share) * t + apart * (double(c) - 1.5);
            p.chains[c].push_back(
                std::clamp(wanted.mean + wanted.sd * z, wanted.prior.low, wanted.prior.high));
        }
    }
    Summarise(&p);
    p.map = p.q50 + 0.1 * p.sd;
    p.rhat = 1.001 + 0.0005 * (seed % 7), p.essBulk = 640 + 10. * seed, p.essTail = 700 + 5. * seed;
    return p;
}

inline std::vector<std::vector<double>> CommonDraws(size_t numChains = 4, size_t numDraws = 500) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::vector<std::vector<double>> chains(numChains, std::vector<double>(numDraws));
    for (std::vector<double>& chain : chains)
        for (double& x : chain) x = normal(random);
    return chains;
}

/// light times red, from the draws of its factors.
inline EstimateParameter LightTimesRed(const EstimateParameter& light, const EstimateParameter& red) {
    EstimateParameter product;
    product.name = product.meaning = "light × red";
    product.factors = {light.name, red.name};
    product.chains = light.chains;
    for (size_t c = 0; c < red.chains.size(); ++c)
        for (size_t i = 0; i < red.chains[c].size(); ++i) product.chains[c][i] *= red.chains[c][i];
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 2000; ++i)
        product.priorDraws.push_back(std::clamp(999 + 500 * normal(random), 1., 2500.) *
                                     std::clamp(0.4 + 0.3 * normal(random), 0.001, 1.));
    product.priorSd = 330;
    Summarise(&product);
    product.map = product.q50, product.truth = 490;
    product.rhat = 1.002, product.essBulk = 900, product.essTail = 880;
    return product;
}

/// Leather, as it should go.
inline EstimateReport GoodReport() {
    EstimateReport report;
    report.title = "leather from wallet.png";
    report.model = "leather";
    report.command = "lacquer estimate wallet.png --model leather --samples 2000 --chains 4 --out wallet";
    report.settings = {{"Method", "emulated"},
                       {"Image", "256 × 256 pixels, 10 cm wide, from 25 cm"},
                       {"Error", "calibrated by simulations"},
                       {"Seed", "1"}};
    const auto common = CommonDraws();
    const TestParameter wanted[] = {
        {"light", "strength of the light", "", {999, 500, 0, 2500}, 1259, 266, 1400},
        {"red", "red albedo", "", {0.4, 0.3, 0, 1}, 0.41, 0.14, 0.35},
        {"rough", "roughness", "", {0.2, 0.2, 0.1, 0.8}, 0.282, 0.027, 0.32},
        {"rough_var", "roughness in creases", "", {0.2, 0.1, 0, 0.4}, 0.19, 0.096, 0.15},
        {"height", "height of the relief", "cm", {0.2, 0.1, 0, 0.5}, 0.205, 0.036, 0.15},
        {"power", "", "", {1.5, 0.2, 1, 2}, 1.69, 0.12, 1.6},
        {"scale", "size of cells", "cm", {0.2, 0.2, 0.01, 1}, 0.309, 0.012, 0.3}};
    const double shares[] = {-0.95, 0.95, 0.1, 0.3, 0.2, -0.5, 0};
    for (uint32_t i = 0; i < std::size(wanted); ++i)
        report.parameters.push_back(MakeParameter(wanted[i], i + 1, common, shares[i]));
    report.parameters.push_back(LightTimesRed(report.parameters[0], report.parameters[1]));
    report.numSummaries = 99, report.misfit = 1.07;
    report.numPredicted = 50;
    std::mt19937 random(11);
    const auto shareOf = [&] { return double(random() % 51) / 50; };
    for (const auto& [family, count, isHeldOut] : {std::tuple("colour", 12, false),
                                                   {"rings", 24, false},
                                                   {"spectrum", 16, false},
                                                   {"histogram", 48, true}}) {
        EstimateCheck check{family, isHeldOut, {}, {}};
        for (int i = 0; i < count; ++i) {
            check.names.push_back(fmt::format("{} {}", family, i + 1));
            check.shares.push_back(std::clamp(shareOf(), i % 16 ? 0.01 : 0, i % 16 ? 0.99 : 1));
        }
        report.checks.push_back(std::move(check));
    }
    report.residuals = {
        {"energy at 8 cycles/cm", -2.1}, {"mean of ring 3", 1.4},     {"mean of red", 0.2},
        {"mean of ring 9", -1.9},        {"contrast of ring 2", 1.1}, {"contrast of ring 5", -0.4}};
    report.waves = {
        {900, kUnknown, 0.4, 0.31, 1.02}, {1250, 1.3, 0.9, 0.28, 1.01}, {1700, 0.12, 1.07, 0.3, 1.004}};
    report.photo = TestPicture(1, 3);
    report.best = TestPicture(2, 3);
    for (uint32_t i = 0; i < 8; ++i) report.draws.push_back(TestPicture(3 + i, 3));
    report.maps.push_back({"albedo", "", true, TestPicture(20, 3)});
    report.maps.push_back({"normal", "", false, TestPicture(21, 3)});
    report.maps.push_back({"height", "cm", false, TestPicture(22, 1, 0.2f)});
    return report;
}

/// Everything bad: markup in each text, chains apart, misfit, a clipped grey photograph, values missing.
inline EstimateReport BadReport() {
    EstimateReport report;
    report.title = report.model = report.command = kHostile;
    report.settings = {{kHostile, kHostile}};
    const auto common = CommonDraws(3, 90);
    for (uint32_t i = 0; i < 23; ++i) {
        report.parameters.push_back(
            MakeParameter({"", "", "", {0.4, 0.2, 0, 1}, 0.93, 0.2, 0.3}, i, common, 0.4, 1.1));
        EstimateParameter& p = report.parameters.back();
        p.name = fmt::format("a_long_name_of_a_parameter_{}", i);
        p.rhat = 1.31 + 0.01 * i, p.essBulk = 30, p.essTail = 41;
        p.truth.reset();
    }
    report.parameters[0].name = report.parameters[1].meaning = report.parameters[1].unit = kHostile;
    EstimateParameter& unknown = report.parameters[2];
    unknown = {};
    unknown.name = "unknown";
    report.parameters[3].essTail = kUnknown;
    report.numSummaries = 40, report.misfit = 17, report.tau = 4.1;
    report.isCalibrated = false, report.handError = 0.02;
    report.hasMeanSettled = false, report.wasStopped = true;
    report.numDivergent = 3, report.lowestEbfmi = 0.1, report.paretoK = 0.9;
    report.warnings = {"The photograph is grey.", kHostile};
    report.numPredicted = 50;
    report.checks = {{kHostile, true, std::vector<std::string>(20, kHostile), std::vector<double>(20, 1.)},
                     {"empty", false, {}, {}}};
    report.checks[0].shares[3] = kUnknown;
    report.residuals = {{kHostile, -16.1}, {"unknown", kUnknown}};
    report.waves = {{900, kUnknown, 14, 0.02, kUnknown}};
    report.photo = TestPicture(1, 1);
    report.maps.push_back({kHostile, kHostile, false, TestPicture(22, 1, 0)});
    return report;
}

/// A best point without chains.
inline EstimateReport MapOnlyReport() {
    EstimateReport report = GoodReport();
    report.isMapOnly = true;
    report.parameters.pop_back();
    for (EstimateParameter& p : report.parameters) {
        EstimateParameter plain;
        plain.name = p.name, plain.meaning = p.meaning, plain.unit = p.unit, plain.map = p.map;
        plain.prior = p.prior, plain.priorSd = p.priorSd;
        p = plain;
    }
    report.checks.clear(), report.residuals.clear(), report.waves.clear(), report.draws.clear(),
        report.maps.clear();
    return report;
}

}  // namespace lacquer::cmd
