#include "ratio_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace lacquer::bench {

Ratio MeanRatio(std::span<const CandidateResult> rows, double LogRatios::*which) {
    std::vector<double> logs, replicas;
    for (const CandidateResult& row : rows) logs.push_back(row.ratios.*which);
    for (size_t i = 0; i < rows[0].replicas.size(); ++i) {
        std::vector<double> replica;
        for (const CandidateResult& row : rows) replica.push_back(row.replicas[i].*which);
        replicas.push_back(GeometricMean(replica));
    }
    Ratio ratio{GeometricMean(logs), {1, 1}, 1, 1};
    if (!replicas.empty()) ratio.interval = CentralInterval(replicas, kConfidence);
    const auto [least, most] = std::minmax_element(logs.begin(), logs.end());
    ratio.least = std::exp(*least);
    ratio.most = std::exp(*most);
    return ratio;
}

namespace {

/// The ratios of candidates, row by row, as if `others` were the baseline.
std::vector<CandidateResult> Against(std::span<const CandidateResult> rows,
                                     std::span<const CandidateResult> others) {
    std::vector<CandidateResult> result(rows.begin(), rows.end());
    for (size_t i = 0; i < result.size(); ++i) {
        result[i].ratios = rows[i].ratios - others[i].ratios;
        for (size_t k = 0; k < result[i].replicas.size(); ++k)
            result[i].replicas[k] = rows[i].replicas[k] - others[i].replicas[k];
    }
    return result;
}

struct NamedRatio {
    const char* name;
    double LogRatios::*which;
};
constexpr NamedRatio kRatios[] = {{"equal_samples", &LogRatios::samples},
                                  {"equal_time", &LogRatios::time},
                                  {"relative_equal_samples", &LogRatios::relativeSamples},
                                  {"relative_equal_time", &LogRatios::relativeTime}};

/// In words.
const char* NameOf(Resampling resampling) {
    switch (resampling) {
        case Resampling::Pairs:
            return "pairs of directions";
        case Resampling::Samples:
            return "random numbers and times";
        case Resampling::Both:
            return "pairs of directions, random numbers and times";
    }
    return "";
}

constexpr int kNameWidth = 24, kEstimatorWidth = 24;

}  // namespace

Report::Report(const ReportOptions& options) : options_(options) {
    json_["baseline"] = options.baseline;
    json_["pairs"] = options.compare.usesUniformPairs ? "uniform" : "lobe";
    json_["num_pairs"] = options.compare.numPairs;
    json_["seconds"] = options.compare.seconds;
    json_["seed"] = options.compare.seed;
    json_["confidence"] = kConfidence;
    json_["resampled"] = NameOf(options.compare.resampling);
    json_["groups"] = nlohmann::ordered_json::array();
    csv_ = "group,configuration,estimator,ns,noise,relative_noise,deviation";
    for (const NamedRatio& ratio : kRatios) csv_ += fmt::format(",{0},{0}_low,{0}_high", ratio.name);
    csv_ += "\n";
}

void Report::PrintLegend() const {
    fmt::print(
        "ns: CPU time of one estimate. noise: RMS over pairs of the deviation of f |cos|, over its mean; rel:"
        " mean over pairs of deviation/mean. samples, time: error (RMSE) of {} over the candidate's at equal"
        " samples and at equal time, above 1 is better, [{:g} % by bootstrap over {}]. rel time: the same for"
        " rel. dev: of the mean from the baseline's, in standard errors. =: geometric means {{least .. "
        "most}}.\n",
        options_.baseline, 100 * kConfidence, NameOf(options_.compare.resampling));
    fmt::print("Directions: {} {} pairs; {:g} s for each estimator and configuration.\n",
               options_.compare.numPairs, options_.compare.usesUniformPairs ? "uniform" : "lobe",
               options_.compare.seconds);
}

void Report::StartGroup(const ConfigurationGroup& group) {
    group_ = group.name;
    byCandidate_.clear();
    json_["groups"].push_back({{"name", group.name}, {"title", group.title}});
    fmt::print("\n{}: {}\n{:<{}} {:<{}} {:>7} {:>8} {:>8} {:>8} {:>8} {:>17} {:>8} {:>6}\n", group.name,
               group.title, "configuration", kNameWidth, "estimator", kEstimatorWidth, "ns", "noise", "rel",
               "samples", "time", "", "rel time", "dev");
}

void Report::PrintResult(const std::string& configuration, const CandidateResult& r, bool isBaseline) const {
    fmt::print("{:<{}} {:<{}} {:>7.0f} {:>8.4f} {:>8.4f}", isBaseline ? configuration : "", kNameWidth,
               r.name, kEstimatorWidth, r.noise.seconds * 1e9, r.noise.RelativeRms(), r.noise.relative);
    if (!isBaseline) {
        const Ratio time = RatioOf(r, &LogRatios::time);
        fmt::print(" {:>8.2f} {:>8.2f} {:>17} {:>8.2f} {:>6.1f}{}", std::exp(r.ratios.samples), time.value,
                   fmt::format("[{:.2f}, {:.2f}]", time.interval.low, time.interval.high),
                   std::exp(r.ratios.relativeTime), r.deviation, std::abs(r.deviation) > 5 ? " !" : "");
    }
    fmt::print("\n");
    std::fflush(stdout);
}

void Report::AddRow(const Configuration& configuration, std::span<const CandidateResult> results) {
    byCandidate_.resize(results.size() - 1);
    nlohmann::ordered_json row = {{"configuration", configuration.name}};
    for (size_t i = 0; i < results.size(); ++i) {
        const CandidateResult& r = results[i];
        if (i > 0) byCandidate_[i - 1].push_back(r);
        PrintResult(configuration.name, r, i == 0);
        nlohmann::ordered_json entry = {{"estimator", r.name},
                                        {"ns", r.noise.seconds * 1e9},
                                        {"noise", r.noise.RelativeRms()},
                                        {"relative_noise", r.noise.relative},
                                        {"is_exact", r.noise.IsExact()},
                                        {"deviation", r.deviation}};
        csv_ += fmt::format("{},\"{}\",{},{},{},{},{}", group_, configuration.name, r.name,
                            r.noise.seconds * 1e9, r.noise.RelativeRms(), r.noise.relative, r.deviation);
        for (const NamedRatio& named : kRatios) {
            const Ratio ratio = RatioOf(r, named.which);
            entry[named.name] = {ratio.value, ratio.interval.low, ratio.interval.high};
            csv_ += fmt::format(",{},{},{}", ratio.value, ratio.interval.low, ratio.interval.high);
        }
        csv_ += "\n";
        row["results"].push_back(std::move(entry));
    }
    json_["groups"].back()["rows"].push_back(std::move(row));
}

void Report::EndGroup() {
    const auto slow = std::find_if(byCandidate_.begin(), byCandidate_.end(),
                                   [](const auto& rows) { return rows[0].name == kSlowBaseline; });
    for (const std::vector<CandidateResult>& rows : byCandidate_) {
        AddSummary(rows, options_.baseline);
        if (slow != byCandidate_.end() && rows[0].name != kSlowBaseline)
            AddSummary(Against(rows, *slow), kSlowBaseline);
    }
}

void Report::AddSummary(std::span<const CandidateResult> rows, const std::string& baseline) {
    const Ratio samples = MeanRatio(rows, &LogRatios::samples), time = MeanRatio(rows, &LogRatios::time);
    const auto wins =
        std::count_if(rows.begin(), rows.end(), [](const CandidateResult& r) { return r.ratios.time > 0; });
    fmt::print(
        "= {:<{}} over {:<{}} samples {:>6.2f} {:<17} time {:>6.2f} {:<16} {:<17} better in {} of {}\n",
        rows[0].name, kEstimatorWidth, baseline, kEstimatorWidth, samples.value,
        fmt::format("{{{:.2f} .. {:.2f}}}", samples.least, samples.most), time.value,
        fmt::format("[{:.2f}, {:.2f}]", time.interval.low, time.interval.high),
        fmt::format("{{{:.2f} .. {:.2f}}}", time.least, time.most), wins, rows.size());
    nlohmann::ordered_json entry = {{"estimator", rows[0].name}, {"baseline", baseline}, {"wins", wins}};
    for (const NamedRatio& named : kRatios) {
        const Ratio r = MeanRatio(rows, named.which);
        entry[named.name] = {{"geometric_mean", r.value},
                             {"interval", {r.interval.low, r.interval.high}},
                             {"min", r.least},
                             {"max", r.most}};
    }
    json_["groups"].back()["summary"].push_back(std::move(entry));
}

void Report::WriteFiles() const {
    const auto write = [](const std::string& path, const std::string& text) {
        if (path.empty()) return;
        std::ofstream file(path);
        file << text;
        file.close();
        if (!file) throw std::runtime_error(fmt::format("cannot write {}", path));
    };
    write(options_.json, json_.dump(2) + "\n");
    write(options_.csv, csv_);
}

}  // namespace lacquer::bench
