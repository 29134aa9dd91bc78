// The numbers of the report as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "cmd/estimate/report.h"
#include "cmd/estimate/report_sentences.h"
#include "cmd/version.h"

namespace lacquer::cmd {
namespace {

using Json = nlohmann::ordered_json;

/// Six digits, so that curves take little room; what is not known becomes null.
Json Short(double value) {
    if (!std::isfinite(value)) return nullptr;
    return std::strtod(fmt::format("{:.5e}", value).c_str(), nullptr);
}
Json Short(const std::vector<double>& values) {
    Json out = Json::array();
    for (const double value : values) out.push_back(Short(value));
    return out;
}

/// Sentences are written for photographs; others that were observed are named by their word.
std::string Said(const EstimateReport& report, std::string text) {
    const std::string word = "photograph";
    if (report.subject == word) return text;
    for (size_t at = text.find(word); at != std::string::npos;
         at = text.find(word, at + report.subject.size()))
        text.replace(at, word.size(), report.subject);
    return text;
}

std::vector<double> Pooled(const EstimateParameter& parameter) {
    std::vector<double> all;
    for (const std::vector<double>& chain : parameter.chains)
        all.insert(all.end(), chain.begin(), chain.end());
    return all;
}

/// Density of values in equal bins over nearly all of them: {from, step, densities}; null for fewer than two
/// values or where all are the same.
Json HistogramOf(std::vector<double> values) {
    if (values.size() < 2) return nullptr;
    std::sort(values.begin(), values.end());
    const size_t beyond = values.size() / 500;  // in each tail
    const double from = values[beyond], to = values[values.size() - 1 - beyond];
    if (!(to > from)) return nullptr;
    const int numBins = std::clamp(int(2 * std::cbrt(double(values.size()))), 5, 36);
    const double step = (to - from) / numBins;
    std::vector<double> densities(size_t(numBins), 0.);
    for (const double value : values)
        if (value >= from && value <= to)
            densities[size_t(std::min(numBins - 1, int((value - from) / step)))] +=
                1 / (step * double(values.size()));
    return {{"from", Short(from)}, {"step", Short(step)}, {"densities", Short(densities)}};
}

/// Points of the density of a cut normal distribution, where it matters.
Json CurveOf(const EstimatePrior& prior) {
    constexpr int kPoints = 97;
    constexpr double kWidth = 3.2;  // standard deviations to each side
    const bool isFlat = !std::isfinite(prior.sd);
    const double from = isFlat ? prior.low : std::max(prior.low, prior.mean - kWidth * prior.sd),
                 to = isFlat ? prior.high : std::min(prior.high, prior.mean + kWidth * prior.sd);
    if (!(to > from)) return nullptr;
    std::vector<double> xs, ys;
    for (int i = 0; i < kPoints; ++i) {
        const double x = std::min(to, from + (to - from) * i / (kPoints - 1));
        xs.push_back(x);
        ys.push_back(isFlat ? 1 / (to - from) : std::exp(prior.LogDensity(x)));
    }
    return {{"x", Short(xs)}, {"y", Short(ys)}};
}

/// The same of draws, by a histogram: the middles of its bins, and its two ends.
Json CurveOf(const std::vector<double>& draws) {
    const Json histogram = HistogramOf(draws);
    if (histogram.is_null()) return nullptr;
    const double from = histogram["from"], step = histogram["step"];
    const std::vector<double> densities = histogram["densities"];
    std::vector<double> xs{from}, ys{densities.front()};
    for (size_t i = 0; i < densities.size(); ++i) {
        xs.push_back(from + (double(i) + 0.5) * step);
        ys.push_back(densities[i]);
    }
    xs.push_back(from + double(densities.size()) * step);
    ys.push_back(densities.back());
    return {{"x", Short(xs)}, {"y", Short(ys)}};
}

/// Every so many-th draw of each of the first chains: {every, values by chain}.
Json TracesOf(const EstimateParameter& parameter) {
    constexpr size_t kChains = 6, kDraws = 240;
    if (parameter.chains.empty() || parameter.chains[0].size() < 2) return nullptr;
    const size_t every = (parameter.chains[0].size() + kDraws - 1) / kDraws;
    Json chains = Json::array();
    for (size_t c = 0; c < std::min(kChains, parameter.chains.size()); ++c) {
        Json values = Json::array();
        for (size_t i = 0; i < parameter.chains[c].size(); i += every)
            values.push_back(Short(parameter.chains[c][i]));
        chains.push_back(std::move(values));
    }
    return {{"every", every}, {"chains", std::move(chains)}};
}

const char* TextOf(ToldBy by) {
    switch (by) {
        case ToldBy::Data:
            return "data";
        case ToldBy::Little:
            return "little";
        case ToldBy::Prior:
            return "prior";
        case ToldBy::Unknown:
            break;
    }
    return "unknown";
}

Json ParameterOf(const EstimateParameter& p) {
    Json entry{{"name", p.name},
               {"meaning", p.meaning},
               {"unit", p.unit},
               {"factors", p.factors},
               {"map", Short(p.map)},
               {"mean", Short(p.mean)},
               {"sd", Short(p.sd)},
               {"q5", Short(p.q5)},
               {"q50", Short(p.q50)},
               {"q95", Short(p.q95)},
               {"prior_sd", Short(p.priorSd)},
               {"sd_ratio", Short(p.sd / p.priorSd)},
               {"told", Short(ShareTold(p))},
               {"told_by", TextOf(WhatTells(p))},
               {"rhat", Short(p.rhat)},
               {"ess_bulk", Short(p.essBulk)},
               {"ess_tail", Short(p.essTail)},
               {"truth", Short(p.truth.value_or(kUnknown))},
               {"interval", IntervalText(p)}};
    if (p.prior) entry["low"] = Short(p.prior->low), entry["high"] = Short(p.prior->high);
    entry["histogram"] = HistogramOf(Pooled(p));
    entry["prior_curve"] = p.prior ? CurveOf(*p.prior) : CurveOf(p.priorDraws);
    entry["traces"] = TracesOf(p);
    return entry;
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double n = double(a.size());
    const double meanA = std::accumulate(a.begin(), a.end(), 0.) / n,
                 meanB = std::accumulate(b.begin(), b.end(), 0.) / n;
    double aa = 0, bb = 0, ab = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        aa += (a[i] - meanA) * (a[i] - meanA);
        bb += (b[i] - meanB) * (b[i] - meanB);
        ab += (a[i] - meanA) * (b[i] - meanB);
    }
    return ab / std::sqrt(aa * bb);
}

/// Correlations of the parameters that are no products, and points of the most correlated pairs.
void PutCorrelations(const EstimateReport& report, Json* results) {
    constexpr size_t kPairs = 6, kPoints = 500;
    std::vector<const EstimateParameter*> parameters;
    std::vector<std::vector<double>> draws;
    for (const EstimateParameter& p : report.parameters) {
        if (!p.factors.empty()) continue;
        std::vector<double> all = Pooled(p);
        if (all.size() < 2 || (!draws.empty() && all.size() != draws[0].size())) continue;
        parameters.push_back(&p);
        draws.push_back(std::move(all));
    }
    (*results)["correlations"] = nullptr;
    (*results)["pairs"] = Json::array();
    if (parameters.size() < 2) return;
    Json names = Json::array(), rows = Json::array();
    struct Pair {
        size_t a, b;
        double correlation;
    };
    std::vector<Pair> pairs;
    for (size_t a = 0; a < draws.size(); ++a) {
        names.push_back(parameters[a]->name);
        Json row = Json::array();
        for (size_t b = 0; b < draws.size(); ++b) {
            const double correlation = Correlation(draws[a], draws[b]);
            row.push_back(Short(correlation));
            if (b > a && std::isfinite(correlation)) pairs.push_back({a, b, correlation});
        }
        rows.push_back(std::move(row));
    }
    (*results)["correlations"] = {{"names", names}, {"values", rows}};
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& first, const Pair& second) {
        return std::abs(first.correlation) > std::abs(second.correlation);
    });
    const size_t every = (draws[0].size() + kPoints - 1) / kPoints;
    for (size_t i = 0; i < std::min(kPairs, pairs.size()); ++i) {
        const Pair& pair = pairs[i];
        Json x = Json::array(), y = Json::array();
        for (size_t k = 0; k < draws[0].size(); k += every) {
            x.push_back(Short(draws[pair.a][k]));
            y.push_back(Short(draws[pair.b][k]));
        }
        (*results)["pairs"].push_back({{"a", parameters[pair.a]->name},
                                       {"b", parameters[pair.b]->name},
                                       {"correlation", Short(pair.correlation)},
                                       {"x", x},
                                       {"y", y}});
    }
}

void PutChecks(const EstimateReport& report, Json* results) {
    constexpr size_t kResiduals = 5;
    (*results)["predicted"] = report.numPredicted;
    (*results)["checks"] = Json::array();
    for (const EstimateCheck& check : report.checks)
        (*results)["checks"].push_back({{"family", check.family},
                                        {"held_out", check.isHeldOut},
                                        {"names", check.names},
                                        {"shares", Short(check.shares)}});
    std::vector<EstimateResidual> residuals;
    for (const EstimateResidual& residual : report.residuals)
        if (std::isfinite(residual.deviation)) residuals.push_back(residual);
    std::stable_sort(residuals.begin(), residuals.end(), [](const auto& first, const auto& second) {
        return std::abs(first.deviation) > std::abs(second.deviation);
    });
    residuals.resize(std::min(kResiduals, residuals.size()));
    (*results)["residuals"] = Json::array();
    for (const EstimateResidual& residual : residuals)
        (*results)["residuals"].push_back({{"name", residual.name},
                                           {"deviation", Short(residual.deviation)},
                                           {"text", Said(report, ResidualText(residual))}});
    (*results)["waves"] = Json::array();
    for (const EstimateWave& wave : report.waves)
        (*results)["waves"].push_back({{"runs", Short(wave.runs)},
                                       {"shift", Short(wave.shift)},
                                       {"misfit", Short(wave.misfit)},
                                       {"acceptance", Short(wave.acceptance)},
                                       {"rhat", Short(wave.maxRhat)}});
}

bool IsThere(const Image& image) { return image.Resolution().x > 0; }

/// The names of images, and the range of those with one channel.
void PutImages(const EstimateReport& report, Json* results) {
    (*results)["linear"] = report.isLinear;
    (*results)["photo"] = IsThere(report.photo) ? Json("photo") : Json(nullptr);
    (*results)["best"] = IsThere(report.best) ? Json("best") : Json(nullptr);
    (*results)["draws"] = Json::array();
    for (size_t i = 0; i < report.draws.size(); ++i)
        (*results)["draws"].push_back(fmt::format("draw {}", i + 1));
    (*results)["maps"] = Json::array();
    for (const EstimateMap& map : report.maps) {
        Json entry{
            {"file", "map " + map.name}, {"name", map.name}, {"unit", map.unit}, {"color", map.isColor}};
        if (map.image.NumChannels() == 1) {
            float least = INFINITY, most = -INFINITY;
            const Int2 size = map.image.Resolution();
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const float value = map.image.Get({x, y}, 0);
                    if (!std::isfinite(value)) continue;
                    least = std::min(least, value);
                    most = std::max(most, value);
                }
            entry["least"] = Short(double(least));
            entry["most"] = Short(double(most));
        }
        (*results)["maps"].push_back(std::move(entry));
    }
}

void PutLobes(const EstimateReport& report, Json* results) {
    (*results)["lobes"] = Json::array();
    for (const EstimateLobe& lobe : report.lobes) {
        Json entry{{"title", lobe.title},
                   {"unit", lobe.unit},
                   {"places", Short(lobe.places)},
                   {"channels", Json::array()}};
        for (const EstimateLobe::Channel& channel : lobe.channels)
            entry["channels"].push_back({{"name", channel.name},
                                         {"measured", Short(channel.measured)},
                                         {"low", Short(channel.low)},
                                         {"median", Short(channel.median)},
                                         {"high", Short(channel.high)}});
        (*results)["lobes"].push_back(std::move(entry));
    }
    (*results)["next_text"] = report.nextText;
    (*results)["next"] = Json::array();
    for (const EstimateNext& next : report.next)
        (*results)["next"].push_back({{"theta_i", Short(next.thetaI)},
                                      {"phi_i", Short(next.phiI)},
                                      {"theta_o", Short(next.thetaO)},
                                      {"phi_o", Short(next.phiO)},
                                      {"deviation", Short(next.deviation)},
                                      {"ratio", Short(next.ratio)}});
}

}  // namespace

nlohmann::ordered_json EstimateReportResults(const EstimateReport& report) {
    Json results{{"schema", "lacquer-estimate-report-1"},
                 {"version", kVersion},
                 {"title", report.title},
                 {"model", report.model},
                 {"command", report.command},
                 {"subject", report.subject},
                 {"verdict", Said(report, VerdictOn(report))},
                 {"converged", HasConverged(report)},
                 {"map_only", report.isMapOnly},
                 {"findings", Json::array()},
                 {"warnings", Json::array()},
                 {"settings", Json::array()},
                 {"misfit", Short(report.misfit)},
                 {"tau", Short(report.tau)},
                 {"summaries", report.numSummaries},
                 {"calibrated", report.isCalibrated}};
    for (const EstimateFinding& finding : FindingsOf(report))
        results["findings"].push_back(
            {{"label", Said(report, finding.label)}, {"text", Said(report, finding.text)}});
    for (const std::string& warning : WarningsOf(report))
        results["warnings"].push_back(Said(report, warning));
    for (const auto& [name, value] : report.settings)
        results["settings"].push_back({{"name", name}, {"value", value}});
    results["parameters"] = Json::array();
    for (const EstimateParameter& p : report.parameters) results["parameters"].push_back(ParameterOf(p));
    PutCorrelations(report, &results);
    PutChecks(report, &results);
    PutLobes(report, &results);
    PutImages(report, &results);
    return results;
}

}  // namespace lacquer::cmd
