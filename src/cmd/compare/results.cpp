#include "cmd/compare/results.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>

#include "cmd/compare/candidates.h"
#include "cmd/compare/images.h"
#include "cmd/version.h"

namespace lacquer::cmd {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no NaN.
Json Number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json ToJson(const compare::Interval& i) {
    return {{"value", Number(i.value)}, {"low", Number(i.low)}, {"high", Number(i.high)}};
}

Json ToJson(compare::Verdict verdict) {
    switch (verdict) {
        case compare::Verdict::Best:
            return "best";
        case compare::Verdict::Indistinguishable:
            return "indistinguishable";
        case compare::Verdict::Worse:
            return "worse";
        case compare::Verdict::Untested:
            break;
    }
    return nullptr;
}

Json ToJson(const std::optional<compare::BiasCheck>& bias) {
    if (!bias) return nullptr;
    return {{"mean_difference", Number(bias->meanDifference)},
            {"standard_error", Number(bias->standardError)},
            {"z", Number(bias->Z())},
            {"relative", Number(bias->relative)}};
}

Json ToJson(const compare::RunRecord& r) {
    return {{"seed", r.seed},
            {"samples_per_pixel", r.samplesPerPixel},
            {"samples_least", r.minSamples},
            {"samples_most", r.maxSamples},
            {"seconds", r.seconds},
            {"denoise_seconds", r.denoiseSeconds},
            {"load_seconds", r.loadSeconds},
            {"bad_samples", r.badSamples}};
}

/// Mean of a member over the runs.
template <class Member>
double Mean(const std::vector<compare::RunRecord>& records, Member member) {
    double sum = 0;
    for (const compare::RunRecord& r : records) sum += double(r.*member);
    return sum / double(records.size());
}

/// The box in the pixels of images whose first pixel is `origin`.
Bounds2i Local(const compare::Box& box, Int2 origin) {
    return {box.pixels.min - origin, box.pixels.max - origin};
}

/// RMSE at 1, 2, 4, ... samples, and that of the whole runs last.
Json Convergence(const compare::CandidateResult& result, const compare::BoxResult& box,
                 const Bounds2i& pixels) {
    Json points = Json::array();
    const int width = result.images[0].Resolution().x;
    const double samples = Mean(result.records, &compare::RunRecord::samplesPerPixel);
    for (const compare::Stage& stage : result.stages)
        if (stage.samples < samples)
            points.push_back({{"samples_per_pixel", stage.samples},
                              {"seconds", stage.seconds / stage.runs},
                              {"rmse", compare::RmseOfSums(stage.squares, width, pixels, stage.runs,
                                                           box.referenceNoise)}});
    points.push_back({{"samples_per_pixel", samples},
                      {"seconds", Mean(result.records, &compare::RunRecord::seconds)},
                      {"rmse", box.rmseCorrected}});
    return points;
}

Json ToJson(const compare::CandidateResult& result, const CompareVariant& variant,
            const std::vector<compare::Box>& boxes, Int2 origin) {
    Json runs = Json::array(), measured = Json::array();
    for (const compare::RunRecord& record : result.records) runs.push_back(ToJson(record));
    for (size_t b = 0; b < boxes.size(); ++b) {
        const compare::BoxResult& r = result.boxes[b];
        measured.push_back({{"name", boxes[b].name},
                            {"rmse", ToJson(r.rmse)},
                            {"rmse_corrected", Number(r.rmseCorrected)},
                            {"relative_mse", ToJson(r.relativeMse)},
                            {"reference_noise_share", Number(r.referenceNoiseShare)},
                            {"shared_errors", Number(r.sharedErrors)},
                            {"bias", ToJson(r.bias)},
                            {"systematic_share", Number(r.systematicShare)},
                            {"flip", result.flips.empty() ? Json(nullptr) : Number(result.flips[b])},
                            {"rmse_reduction", ToJson(r.rmseReduction)},
                            {"time_reduction", ToJson(r.timeReduction)},
                            {"rmse_over_best", ToJson(r.rmseOverBest)},
                            {"verdict", ToJson(r.verdict)},
                            {"p_equal", Number(r.pEqual)},
                            {"convergence", Convergence(result, r, Local(boxes[b], origin))}});
    }
    const double samples = Mean(result.records, &compare::RunRecord::samplesPerPixel);
    const double seconds = Mean(result.records, &compare::RunRecord::seconds);
    const Int2 size = result.images[0].Resolution();
    return {{"name", result.candidate.Label()},
            {"approximate", IsApproximate(result.candidate)},
            {"runs", runs},
            {"samples_per_pixel", samples},
            {"seconds", seconds},
            {"microseconds_per_sample", 1e6 * seconds / (samples * size.x * size.y)},
            {"images",
             {{"run", RunImageName(variant, result.candidate, 0)},
              {"error", ErrorImageName(variant, result.candidate)}}},
            {"boxes", measured}};
}

std::string Processor() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("model name")) {
            const size_t begin = line.find_first_not_of(" \t", line.find(':') + 1);
            if (begin != std::string::npos) return line.substr(begin);
        }
    return "unknown";
}

std::string System() {
    utsname name{};
    if (uname(&name) != 0) return "unknown";
    return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

/// "1.83 [1.71, 1.95]".
std::string NumberInWords(const Json& interval) {
    if (interval["value"].is_null()) return "-";
    const double value = interval["value"];
    if (interval["low"].is_null()) return fmt::format("{:.3g}", value);
    return fmt::format("{:.3g} [{:.3g}, {:.3g}]", value, double(interval["low"]), double(interval["high"]));
}

/// "auto and halfvector are indistinguishable": who has the least error in a box. Empty if there is
/// nobody else.
std::string VerdictInWords(const Json& variant, size_t box) {
    std::vector<std::string> best;
    for (const Json& e : variant["estimators"]) {
        const Json& verdict = e["boxes"][box]["verdict"];
        if (verdict == "best") best.insert(best.begin(), e["name"]);
        if (verdict == "indistinguishable") best.push_back(e["name"]);
    }
    if (variant["estimators"].size() < 2) return "";
    if (best.empty()) return "  who has the least error cannot be told: the reference is too noisy\n";
    if (best.size() == 1) return fmt::format("  {} has the least error\n", best[0]);
    const std::string last = best.back();
    best.pop_back();
    return fmt::format("  {} and {} are indistinguishable\n", fmt::join(best, ", "), last);
}

}  // namespace

std::string RunImageName(const CompareVariant& variant, const compare::Candidate& candidate, size_t run) {
    return fmt::format("images/{}{}-run{}.exr", variant.filePrefix, FileWord(candidate.Label()), run + 1);
}

std::string ErrorImageName(const CompareVariant& variant, const compare::Candidate& candidate) {
    return fmt::format("images/{}{}-rmse.exr", variant.filePrefix, FileWord(candidate.Label()));
}

nlohmann::ordered_json ToJson(const CompareSetting& s, bool isComplete) {
    Json boxes = Json::array();
    for (const compare::Box& box : s.boxes)
        boxes.push_back(
            {{"name", box.name},
             {"pixels", {box.pixels.min.x, box.pixels.max.x, box.pixels.min.y, box.pixels.max.y}}});
    const Json budget = s.budget.seconds
                            ? Json{{"kind", "time"}, {"seconds", *s.budget.seconds}}
                            : Json{{"kind", "samples"}, {"samples_per_pixel", s.budget.samplesPerPixel}};
    return {{"schema", "lacquer-compare-1"},
            {"version", kVersion},
            {"created", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
            {"command", s.command},
            {"machine", {{"processor", Processor()}, {"threads", s.threads}, {"system", System()}}},
            {"scene", s.scene},
            {"resolution", {s.resolution.x, s.resolution.y}},
            {"budget", budget},
            {"runs", s.runs},
            {"complete", isComplete},
            {"compared", compare::NounOf(s.subject)},
            {"baseline", s.baseline},
            {"estimators", s.estimators},
            {"boxes", boxes},
            {"files", Json::array()},
            {"variants", Json::array()}};
}

nlohmann::ordered_json ToJson(const CompareVariant& variant, const std::vector<compare::Box>& boxes,
                              Int2 origin) {
    const compare::Reference& reference = variant.reference;
    Json estimators = Json::array();
    for (const compare::CandidateResult& result : variant.results)
        estimators.push_back(ToJson(result, variant, boxes, origin));
    return {{"label", variant.label},
            {"reference",
             {{"image", variant.referenceFile},
              {"source", variant.isReferenceGiven ? "file" : "rendered"},
              {"estimator", reference.renderedBy.empty() ? Json(nullptr) : Json(reference.renderedBy)},
              {"samples_per_pixel",
               reference.samplesPerPixel > 0 ? Json(reference.samplesPerPixel) : Json(nullptr)},
              {"noise", reference.NoiseIsKnown() ? "measured" : "estimated"}}},
            {"estimators", estimators}};
}

namespace {

/// The last columns: of denoisers FLIP and what part of the squared error all runs share, else the bias of
/// the mean.
std::string LastColumnsHead(bool isOfDenoisers) {
    return isOfDenoisers ? fmt::format("{:>8}{:>12}", "FLIP", "systematic") : fmt::format("{:>8}", "bias/se");
}
std::string LastColumns(bool isOfDenoisers, const Json& box) {
    const Json &bias = box["bias"], &share = box["systematic_share"], &flip = box["flip"];
    if (isOfDenoisers)
        return fmt::format("{:>8}{:>12}", flip.is_null() ? "-" : fmt::format("{:.3f}", double(flip)),
                           share.is_null() ? "-" : fmt::format("{:.0f} %", 100 * double(share)));
    return fmt::format("{:>8}", bias.is_null() ? "-" : fmt::format("{:.1f}", double(bias["z"])));
}

}  // namespace

std::string ToText(const nlohmann::ordered_json& results) {
    const bool isOfDenoisers = results["compared"] == compare::NounOf(compare::Subject::Denoisers);
    std::string text;
    for (const Json& variant : results["variants"]) {
        if (!std::string(variant["label"]).empty())
            text += fmt::format("{}\n", std::string(variant["label"]));
        for (size_t b = 0; b < results["boxes"].size(); ++b) {
            text +=
                fmt::format("{:<16}{:>9}{:>11}  {:<30}{:<28}{}\n", std::string(results["boxes"][b]["name"]),
                            "samples", "us/sample", "RMSE", "RMSE reduction", LastColumnsHead(isOfDenoisers));
            for (const Json& e : variant["estimators"]) {
                const Json& box = e["boxes"][b];
                text += fmt::format("  {:<14}{:>9.1f}{:>11.3f}  {:<30}{:<28}{}\n", std::string(e["name"]),
                                    double(e["samples_per_pixel"]), double(e["microseconds_per_sample"]),
                                    NumberInWords(box["rmse"]), NumberInWords(box["rmse_reduction"]),
                                    LastColumns(isOfDenoisers, box));
            }
            text += VerdictInWords(variant, b);
        }
    }
    return text;
}

}  // namespace lacquer::cmd
