#include "cmd/estimate/posterior_files.h"

#include <fmt/format.h>

#include <cmath>

#include "cmd/command_support.h"
#include "cmd/version.h"
#include "estimate/output/chain_files.h"
#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::cmd {

using namespace estimate;
namespace {
using Json = nlohmann::ordered_json;

/// "parameters": those that are estimated and those that are fixed.
void AddAllParameters(const PhotoSimulator& simulator, const Vector& estimated, Json* json) {
    const std::vector<double> all = simulator.AllParameters(estimated);
    for (size_t i = 0; i < all.size(); ++i)
        (*json)["parameters"][std::string(simulator.Model().Parameters()[i].name)] = all[i];
}

}  // namespace

Json PriorsOf(const ParameterSpace& space) {
    Json priors = Json::object();
    for (const estimate::Parameter& p : space.All())
        priors[p.name] = {p.prior.mean, p.prior.sd, p.prior.low, p.prior.high};
    return priors;
}

std::string HashText(std::string_view bytes) { return fmt::format("{:016x}", HashOfBytes(bytes)); }

void AddChainSettings(const EstimateArguments& a, Json* config) {
    (*config)["seed"] = a.seed;
    (*config)["chains"] = a.chains;
    (*config)["samples"] = a.samples;
    (*config)["warmup"] = a.warmup;
}

Json ReadJson(const std::string& path) {
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = size_t(64) << 20});
    Json json = Json::parse(bytes.View(), nullptr, false);
    if (json.is_discarded() || !json.is_object()) throw SceneError({path}, "expected JSON, an object");
    return json;
}

Json ConfigOf(const EstimateArguments& a, const PhotoSimulator& simulator, const PhotographFile& photo,
              std::string_view photoBytes) {
    const PhotoSettings& s = simulator.Settings();
    Json config;
    config["by"] = fmt::format("Lacquer {}", kVersion);
    config["photo"] = a.photo;
    config["photo_hash"] = HashText(photoBytes);
    config["crop"] = {photo.crop.min.x, photo.crop.max.x, photo.crop.min.y, photo.crop.max.y};
    config["model"] = std::string(simulator.Model().Name());
    config["method"] = a.mapOnly ? "mode, " + a.method : a.method;
    config["sampler"] = a.sampler;
    config["seeds"] = a.seeds;
    config["error"] = a.error;
    config["resolution"] = s.resolution;
    config["averaging"] = s.averaging;
    config["size_cm"] = s.extent;
    config["distance_cm"] = s.distance;
    config["tone"] = a.tone;
    config["brdf"] = a.brdf;
    config["cells"] = a.cells;
    config["noise"] = a.noise;
    if (!a.vgg.empty())
        config["vgg_hash"] = HashText(ReadFileBytes(a.vgg, {}, {.maxBytes = size_t(4) << 30}).View());
    config["summaries"] = simulator.Families();
    config["priors"] = PriorsOf(simulator.Parameters());
    config["fixed"] = a.fixed;
    AddChainSettings(a, &config);
    return config;
}

void CheckSameConfig(const std::string& path, const Json& config) {
    const Json before = ReadJson(path);
    std::string differ;
    for (const auto& [name, value] : config.items())
        if (name != "photo" && (!before.contains(name) || before[name] != value))
            differ += (differ.empty() ? "" : ", ") + name;
    if (!differ.empty())
        throw FileError(
            path,
            fmt::format("is of a run with other settings ({}); expected the same ones to resume it", differ));
}

void WriteChains(const std::string& folder, const PhotoSimulator& simulator, const EstimateArguments& a,
                 const PosteriorChains& chains, const Matrix& predicted, const Vector& observed) {
    WriteChains(folder, simulator.Parameters(), std::string(simulator.Model().Name()),
                simulator.SummaryNames(), a, chains, predicted, observed);
}

void WriteChains(const std::string& folder, const ParameterSpace& space, const std::string& model,
                 const std::vector<std::string>& names, const EstimateArguments& a,
                 const PosteriorChains& chains, const Matrix& predicted, const Vector& observed) {
    ChainHeader header;
    header.model = model;
    header.settings = {{"method", a.method}, {"seed", std::to_string(a.seed)}};
    header.numWarmup = uint64_t(a.warmup);
    for (size_t c = 0; c < chains.draws.size(); ++c)
        WriteText(fmt::format("{}/chain-{}.csv", folder, c + 1),
                  StanCsv(space, header, chains.states[c], chains.draws[c]));
    constexpr int kPriorDraws = 1000;
    InferenceData data;
    data.chains = chains.draws;
    data.priorDraws = Matrix(Eigen::Index(space.Size()), kPriorDraws);
    for (int k = 0; k < kPriorDraws; ++k) {
        Random random(a.seed, k);
        data.priorDraws.col(k) = space.ToLogit(space.SamplePrior(random));
    }
    data.summaryNames = names;
    data.observed = observed;
    data.predictive = predicted;
    data.attributes = {{"created_by", fmt::format("Lacquer {}", kVersion)},
                       {"model", header.model},
                       {"seed", std::to_string(a.seed)}};
    WriteText(folder + "/posterior.json", ArviZJson(space, data));
}

std::vector<std::string> SummaryLines(const PosteriorSummary& summary) {
    std::vector<std::string> lines = {fmt::format("{:<14}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>9}{:>8}{:>7}",
                                                  "parameter", "MAP", "mean", "sd", "5 %", "50 %", "95 %",
                                                  "sd/prior", "R-hat", "ESS")};
    for (const EstimateParameter& s : summary.parameters)
        lines.push_back(
            s.factors.empty()
                ? fmt::format(
                      "{:<14}{:>11.4g}{:>11.4g}{:>11.3g}{:>11.4g}{:>11.4g}{:>11.4g}{:>9.2f}{:>8.3f}{:>7.0f}",
                      s.name, s.map, s.mean, s.sd, s.q5, s.q50, s.q95, s.sd / s.priorSd, s.rhat,
                      std::min(s.essBulk, s.essTail))
                : fmt::format("{:<14}{:>11}{:>11.4g}{:>11.3g}{:>11.4g}{:>11}{:>11.4g}", s.name, "", s.mean,
                              s.sd, s.q5, "", s.q95));
    return lines;
}

void WriteSummary(const std::string& folder, const PosteriorSummary& summary) {
    std::string text, csv = "parameter,unit,map,mean,sd,q05,q50,q95,prior_sd,rhat,ess_bulk,ess_tail\n";
    for (const std::string& line : SummaryLines(summary)) text += line + '\n';
    for (const EstimateParameter& s : summary.parameters)
        if (s.factors.empty())
            csv += fmt::format(
                "{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g}\n", s.name,
                s.unit, s.map, s.mean, s.sd, s.q5, s.q50, s.q95, s.priorSd, s.rhat, s.essBulk, s.essTail);
    WriteText(folder + "/summary.txt", text);
    WriteText(folder + "/summary.csv", csv);
}

std::vector<std::string> ModeLines(const ParameterSpace& space, const Vector& mode) {
    std::vector<std::string> lines = {fmt::format("{:<14}{:>11}", "parameter", "MAP")};
    for (size_t i = 0; i < space.Size(); ++i)
        lines.push_back(fmt::format("{:<14}{:>11.4g}", space[i].name, mode[Eigen::Index(i)]));
    return lines;
}

void WriteMode(const std::string& folder, const PhotoSimulator& simulator, const Vector& mode) {
    Json json;
    json["model"] = std::string(simulator.Model().Name());
    AddAllParameters(simulator, mode, &json);
    WriteText(folder + "/map.json", JsonText(json, 2) + "\n");
}

void WriteTruth(const std::string& path, const EstimateArguments& a, const PhotoSimulator& simulator,
                const Vector& parameters) {
    Json json;
    json["model"] = std::string(simulator.Model().Name());
    json["seed"] = a.seed;
    json["size_cm"] = simulator.Settings().extent;
    json["distance_cm"] = simulator.Settings().distance;
    json["tone"] = a.tone;
    AddAllParameters(simulator, parameters, &json);
    WriteText(path, JsonText(json, 2) + "\n");
}

std::map<std::string, double> ReadTruth(const std::string& path, const ParameterSpace& space,
                                        const char* subject) {
    const Json json = ReadJson(path);
    if (!json.contains("parameters") || !json["parameters"].is_object())
        throw SceneError({path}, fmt::format("expected the truth of a {}, with \"parameters\"", subject));
    std::map<std::string, double> truth;
    for (const auto& [name, value] : json["parameters"].items()) {
        if (!space.Find(name)) continue;
        if (!value.is_number())
            throw SceneError({path}, fmt::format("parameter \"{}\" is {}; expected a number", name,
                                                 Excerpt(value.dump())));
        truth[name] = value.get<double>();
    }
    if (truth.empty())
        throw SceneError({path}, fmt::format("has no parameter that is estimated; expected some of {}",
                                             fmt::join(space.Names(), ", ")));
    return truth;
}

}  // namespace lacquer::cmd
