// lacquer-materialgan evaluate: fits of materials whose maps are known, with a generator and without.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/materialgan/evaluation_trial.h"
#include "cmd/materialgan/generator_path.h"
#include "cmd/materialgan/map_files.h"
#include "materialgan/maps_sheet.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using capture::Maps;
using Json = nlohmann::ordered_json;

/// Of FitMethod, for the table and the file.
constexpr std::array<const char*, NumMethods> kMethods = {
    "texels",  "texels, smooth", "coarse to fine", "texels, better",
    "latents", "and refined",    "with fallback"};

constexpr size_t kMaxOnSheet = 10;  // materials on a sheet

Json ToJson(const EvaluationCase& known, const TrialResult& result) {
    Json entry = {{"family", known.family},
                  {"held_out_family", known.isHeldOut},
                  {"style_energy", result.styleEnergy},
                  {"noise_energy", result.noiseEnergy},
                  {"doubted", result.isDoubted}};
    for (size_t m = 0; m < NumMethods; ++m) {
        const FitErrors& e = result.errors[m];
        entry[kMethods[m]] = {{"novel_rmse", e.novel},    {"novel_flip", e.flip},   {"novel_ssim", e.ssim},
                              {"input_rmse", e.input},    {"albedo", e.albedo},     {"normal", e.normal},
                              {"roughness", e.roughness}, {"specular", e.specular}, {"seconds", e.seconds}};
    }
    return entry;
}

std::string TableOf(const std::vector<EvaluationCase>& cases, const std::vector<TrialResult>& results) {
    std::array<int, 2> counts{};
    for (const EvaluationCase& c : cases) ++counts[c.isHeldOut];
    std::string table =
        fmt::format("{} materials of trained families, {} of another\n", counts[0], counts[1]);
    table +=
        "                   trained   other    FLIP    SSIM   input  albedo  normal roughn. specul. "
        "seconds\n";
    for (size_t m = 0; m < NumMethods; ++m) {
        std::array<FitErrors, 2> mean;
        FitErrors all;
        for (size_t i = 0; i < cases.size(); ++i) {
            mean[cases[i].isHeldOut].Add(results[i].errors[m], 1. / counts[cases[i].isHeldOut]);
            all.Add(results[i].errors[m], 1. / double(cases.size()));
        }
        const auto novelOf = [&](size_t group) {
            return counts[group] > 0 ? fmt::format("{:.4f}", mean[group].novel) : "none";
        };
        table += fmt::format(
            "{:<18} {:>7} {:>7} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.4f} {:7.1f}\n",
            kMethods[m], novelOf(0), novelOf(1), all.flip, all.ssim, all.input, all.albedo, all.normal,
            all.roughness, all.specular, all.seconds);
    }
    return table;
}

/// The materials, and below them what texels and what the generator make of their photographs.
void WriteSheet(const std::vector<EvaluationCase>& cases, const std::vector<TrialResult>& results,
                const std::string& path) {
    std::vector<std::vector<Maps>> rows(3);
    for (size_t i = 0; i < std::min(results.size(), kMaxOnSheet); ++i) {
        rows[0].push_back(cases[i].truth);
        rows[1].push_back(results[i].texels);
        rows[2].push_back(results[i].refined);
    }
    WriteImage(materialgan::MapsSheet(rows), path);
}

void WriteNumbers(const std::vector<EvaluationCase>& cases, const std::vector<TrialResult>& results,
                  const MaterialganArguments& a, int size) {
    Json file = {{"generator", a.file},
                 {"views", a.views},
                 {"seed", a.seed},
                 {"resolution", size},
                 {"materials", Json::array()}};
    for (size_t i = 0; i < cases.size(); ++i) file["materials"].push_back(ToJson(cases[i], results[i]));
    WriteText(a.out, JsonText(file, 2) + "\n");
}

/// A capture goes on to a size of photographs, an evaluation stays at the generator's unless asked to.
CaptureSizes SizesOfEvaluation(const MaterialganArguments& a, int generatorSize) {
    CaptureArguments capture = a.capture;
    if (!capture.finalResolution) capture.finalResolution = generatorSize;
    return SizesOf(capture, generatorSize);
}

}  // namespace

ExitStatus RunEvaluate(const MaterialganArguments& a) {
    for (const std::string& out : {a.out, a.sheet})
        if (!out.empty()) CheckOutputFile(out);
    const ThreadLimit limit(a.threads);
    const materialgan::MaterialPrior prior(GeneratorPath(a.file));
    UseThreads(prior, a.threads);
    const CaptureSizes sizes = SizesOfEvaluation(a, prior.Config().resolution);
    Console console(ConsoleStyle::Detect(a.quiet));
    Console::CatchSignals();
    capture::FitSettings settings;
    settings.iterations = a.texelIterations;
    settings.totalVariation = a.capture.totalVariation;
    std::vector<EvaluationCase> cases;
    std::vector<TrialResult> results;
    console.Begin("Evaluation", a.count, "");
    for (int i = 0; i < a.count && !console.ShouldStop(); ++i) {
        cases.push_back(EvaluationCaseOf(i, sizes.last, a.seed));
        results.push_back(RunTrial(cases.back(), prior, a, settings));
        if (results.size() > kMaxOnSheet) results.back().texels = results.back().refined = Maps();
        console.Advance(1);
    }
    console.End();
    if (results.empty()) return Console::StatusOfSignal();
    if (!a.out.empty()) WriteNumbers(cases, results, a, sizes.last);
    if (!a.sheet.empty()) WriteSheet(cases, results, a.sheet);
    std::cout << TableOf(cases, results);
    return console.ShouldStop() ? Console::StatusOfSignal() : ExitStatus::Complete;
}

}  // namespace lacquer::cmd
