#include "estimate/output/chain_files.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace lacquer::estimate {

namespace {

using Json = nlohmann::ordered_json;

/// An array of chain x draw of what `value` says of each draw.
template <class F>
Json PerDraw(const std::vector<std::vector<Draw>>& chains, F value) {
    Json all = Json::array();
    for (const auto& chain : chains) {
        Json row = Json::array();
        for (const Draw& draw : chain) row.push_back(value(draw));
        all.push_back(std::move(row));
    }
    return all;
}

/// What JSON has for numbers that are not finite.
Json Finite(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json RowOf(const Vector& values) {
    Json row = Json::array();
    for (const double value : values) row.push_back(Finite(value));
    return row;
}

Json StatisticsOf(const std::vector<std::vector<Draw>>& chains) {
    Json statistics;
    statistics["lp"] = PerDraw(chains, [](const Draw& d) { return Finite(d.logDensity); });
    statistics["acceptance_rate"] = PerDraw(chains, [](const Draw& d) { return Finite(d.acceptStat); });
    statistics["step_size"] = PerDraw(chains, [](const Draw& d) { return Finite(d.stepSize); });
    statistics["n_steps"] = PerDraw(chains, [](const Draw& d) { return d.numLeapfrog; });
    statistics["diverging"] = PerDraw(chains, [](const Draw& d) { return d.isDivergent; });
    statistics["energy"] = PerDraw(chains, [](const Draw& d) { return Finite(d.energy); });
    return statistics;
}

}  // namespace

std::string StanCsv(const ParameterSpace& space, const ChainHeader& header, const ChainState& last,
                    const std::vector<Draw>& draws) {
    std::string text = fmt::format("# model = {}\n", header.model);
    for (const auto& [name, value] : header.settings) text += fmt::format("# {} = {}\n", name, value);
    text +=
        fmt::format("# num_warmup = {}\n# save_warmup = {}\n", header.numWarmup, header.savesWarmup ? 1 : 0);
    text += "lp__,accept_stat__,stepsize__,n_leapfrog__,divergent__,energy__";
    for (const std::string& name : space.Names()) text += "," + name;
    text += "\n";
    const auto adaptation = [&] {
        text += fmt::format("# Adaptation terminated\n# Step size = {:.17g}\n",
                            draws.empty() ? std::exp(last.adaptation.logStep) : draws.back().stepSize);
        text += "# Diagonal elements of inverse mass matrix:\n# ";
        for (Eigen::Index i = 0; i < last.metric.size(); ++i)
            text += fmt::format("{}{:.17g}", i > 0 ? ", " : "", last.metric[i]);
        text += "\n";
    };
    const size_t numWarmup = header.savesWarmup ? std::min(size_t(header.numWarmup), draws.size()) : 0;
    for (size_t i = 0; i <= draws.size(); ++i) {
        if (i == numWarmup) adaptation();
        if (i == draws.size()) break;
        const Draw& d = draws[i];
        text += fmt::format("{:.17g},{:.17g},{:.17g},{},{},{:.17g}", d.logDensity, d.acceptStat, d.stepSize,
                            d.numLeapfrog, d.isDivergent ? 1 : 0, d.energy);
        for (const double x : space.ToNatural(d.y)) text += fmt::format(",{:.17g}", x);
        text += "\n";
    }
    return text;
}

std::string ArviZJson(const ParameterSpace& space, const InferenceData& data) {
    Json json;
    const std::vector<std::string> names = space.Names();
    json["posterior"] = Json::object();
    json["prior"] = Json::object();
    for (size_t i = 0; i < names.size(); ++i)
        json["posterior"][names[i]] = PerDraw(
            data.chains, [&](const Draw& d) { return Finite(space.ToNatural(d.y)[Eigen::Index(i)]); });
    json["sample_stats"] = StatisticsOf(data.chains);
    for (size_t i = 0; i < names.size(); ++i) {
        Json row = Json::array();
        for (Eigen::Index k = 0; k < data.priorDraws.cols(); ++k)
            row.push_back(Finite(space.ToNatural(data.priorDraws.col(k))[Eigen::Index(i)]));
        json["prior"][names[i]] = Json::array({row});
    }
    json["observed_data"]["summary"] = RowOf(data.observed);
    Json predictive = Json::array();
    for (Eigen::Index k = 0; k < data.predictive.rows(); ++k)
        predictive.push_back(RowOf(data.predictive.row(k)));
    json["posterior_predictive"]["summary"] = Json::array({predictive});
    json["coords"]["summary_dim_0"] = data.summaryNames;
    json["attrs"] = Json::object();
    for (const auto& [name, value] : data.attributes) json["attrs"][name] = value;
    return json.dump(1) + "\n";
}

}  // namespace lacquer::estimate
