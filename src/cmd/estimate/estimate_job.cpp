#include "cmd/estimate/estimate_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "cmd/command_support.h"
#include "cmd/estimate/estimate_run.h"
#include "cmd/estimate/explain.h"
#include "cmd/estimate/material_files.h"
#include "cmd/estimate/photo_inference.h"
#include "cmd/estimate/photo_report.h"
#include "cmd/estimate/posterior_files.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/estimate/purpose.h"
#include "cmd/estimate/report_sentences.h"
#include "estimate/calibration/simulation_based.h"
#include "estimate/emulator/emulated_posterior.h"
#include "estimate/summary/vgg.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using namespace estimate;
using Json = nlohmann::ordered_json;

constexpr int kNumPredictions = 100;

bool Has(const std::vector<std::string>& families, const char* family) {
    return std::find(families.begin(), families.end(), family) != families.end();
}

std::vector<std::string> HeldOutFamilies(const PhotoSimulator& simulator) {
    std::vector<std::string> families;
    for (const char* family : {"gram", "histogram"})
        if (!Has(simulator.Families(), family)) families.emplace_back(family);
    return families;
}

class PhotoRun final : public EstimateRun {
  public:
    PhotoRun(const EstimateArguments& arguments, Console* console)
        : EstimateRun(arguments, console), results_{.arguments = arguments} {}

  private:
    // ---- Before the work ----

    void Prepare() override {
        FreeParametersOf(a_, ModelOf(a_));
        CheckMethod(a_);
        const auto vgg = a_.vgg.empty() ? nullptr : VggWeights::Read(a_.vgg);
        results_.photo = ReadPhotograph(a_.photo, ReadingOf(a_));
        for (const std::string& note : results_.photo.notes) console_->Info("note: " + note);
        for (const std::string& warning : results_.photo.warnings) console_->Warn("warning: " + warning);
        PhotoSettings settings = PhotoSettingsOf(a_, &results_.photo);
        settings.vgg = vgg;
        if (!a_.size && !a_.distance)
            console_->Info(
                fmt::format("note: the photograph is taken to show {:.4g} cm from {:.4g} cm away; --size and "
                            "--distance say it better",
                            settings.extent, settings.distance));
        MakeSimulators(settings);
        CheckSomethingIsFree(results_.Simulator());
        CheckSampler(a_, results_.Simulator().Parameters(), results_.kinds.size());
        if (!a_.truth.empty())
            results_.truth = ReadTruth(a_.truth, results_.Simulator().Parameters(), "photograph");
        ApplyTone(settings.tone, results_.photo.linear, &results_.image);
        observed_ = results_.Simulator().SummariesOf(results_.image);
        MakeKindSummaries();
    }

    void MakeSimulators(PhotoSettings settings) {
        std::vector<std::string> families = a_.summaries;
        if (settings.vgg && !Has(families, "vgg")) {
            if (families.empty()) families = DefaultSummaries(ModelOf(a_));
            families.emplace_back("vgg");
        }
        for (const ModelKinds& kinds : KindsOf(a_, ModelOf(a_))) {
            settings.kinds = kinds;
            results_.kinds.push_back(SimulatorOf(a_, settings, families));
        }
        for (const std::string& warning : results_.Simulator().Warnings())
            console_->Warn("warning: " + warning);
        for (const std::string& note : results_.Simulator().Notes()) console_->Info("note: priors " + note);
    }

    /// Histograms tell kinds of noise apart, and next to nothing of a parameter that other summaries do not.
    void MakeKindSummaries() {
        std::vector<std::string> families = results_.Simulator().Families();
        if (results_.kinds.size() < 2 || !a_.summaries.empty() || Has(families, "histogram")) return;
        families.emplace_back("histogram");
        kindSummaries_.emplace();
        for (const auto& kind : results_.kinds)
            kindSummaries_->simulators.push_back(SimulatorOf(a_, kind->Settings(), families));
        kindSummaries_->observed = kindSummaries_->simulators[0]->SummariesOf(results_.image);
    }

    Json MakeConfig() const override {
        const FileBytes bytes = ReadFileBytes(a_.photo, {}, {.maxBytes = size_t(4) << 30});
        return ConfigOf(a_, results_.Simulator(), results_.photo, bytes.View());
    }

    // ---- The work ----

    void Infer() override {
        results_.posterior = InferFromSummaries({a_, results_.kinds, observed_, Settings(), &observer_,
                                                 kindSummaries_ ? &*kindSummaries_ : nullptr});
        if (a_.mapOnly) return;
        const ParameterSpace& space = results_.Simulator().Parameters();
        results_.summary = Summarize(space, results_.posterior.chains, results_.posterior.mode,
                                     Hash(a_.seed, uint64_t(Purpose::PhotoProducts)));
        std::unique_ptr<PhotoSimulator> heldOut;
        if (const std::vector<std::string> families = HeldOutFamilies(results_.Simulator());
            !families.empty())
            heldOut = SimulatorOf(a_, results_.Simulator().Settings(), families);
        results_.predictive = PredictAndCheck(results_.Simulator(), heldOut.get(), results_.image,
                                              results_.posterior.chains.Natural(space), kNumPredictions,
                                              Hash(a_.seed, uint64_t(Purpose::Predictions)), &observer_);
    }

    // ---- After it ----

    void Write() override {
        if (!a_.mapOnly) {
            WriteChains(a_.out, results_.Simulator(), a_, results_.posterior.chains,
                        results_.predictive.summaries, observed_);
            WriteSummary(a_.out, results_.summary);
        }
        WriteMode(a_.out, results_.Simulator(), results_.posterior.mode);
        if (results_.kinds.size() > 1) WriteKinds();
        if (a_.explain) Explain();
        WriteMaterialFiles(a_.out, MaterialOf(a_, results_.Simulator(), results_.posterior.mode,
                                              Hash(a_.seed, uint64_t(Purpose::Maps))));
        WriteEstimateReport(a_.out, ReportOf(results_));
    }

    /// kinds.json: how probable each of them is.
    void WriteKinds() {
        Json json = Json::array();
        for (size_t k = 0; k < results_.kinds.size(); ++k) {
            const ModelKinds& kinds = results_.kinds[k]->Settings().kinds;
            Json entry{{"cells", std::string(CellKindNames()[size_t(kinds.cells)])},
                       {"noise", std::string(NoiseKindNames()[size_t(kinds.noise)])}};
            if (!results_.posterior.kindProbabilities.empty())
                entry["probability"] = results_.posterior.kindProbabilities[k];
            json.push_back(std::move(entry));
        }
        WriteText(a_.out + "/kinds.json", JsonText(json, 2) + "\n");
    }
    void Explain() {
        const std::string table = FamilyTable(a_, results_.Simulator(), results_.posterior.mode);
        WriteText(a_.out + "/explain.txt", table);
        console_->Info(table);
    }

    ExitStatus Finish() override {
        const auto lines = a_.mapOnly ? ModeLines(results_.Simulator().Parameters(), results_.posterior.mode)
                                      : SummaryLines(results_.summary);
        for (const std::string& line : lines) console_->Info(line);
        if (results_.kinds.size() > 1) console_->Info("kinds: " + KindsText(results_));
        console_->Info(fmt::format("{}: {}; misfit {:.2f} for each summary", a_.out,
                                   results_.posterior.method, results_.posterior.misfit));
        if (!results_.posterior.waves.empty())
            console_->Info(fmt::format("the last wave moved the means by at most {:.2f} deviations",
                                       results_.posterior.waves.back().shift));
        if (results_.posterior.tau > 1)
            console_->Warn(
                fmt::format("warning: the model misses the photograph by {:.2g} of its own deviations{}",
                            results_.posterior.tau, a_.mapOnly ? "" : "; the intervals are that much wider"));
        if (results_.posterior.hasMeanSettled && (a_.mapOnly || results_.summary.HasConverged()))
            return ExitStatus::Complete;
        return NotConverged(results_.posterior.hasMeanSettled, results_.summary,
                            results_.posterior.waves.empty() ? 0 : results_.posterior.waves.back().shift,
                            results_.posterior.allowedShift);
    }

    PhotoResults results_;
    Vector observed_;
    std::optional<KindSummaries> kindSummaries_;
};

}  // namespace

ExitStatus EstimateFromPhotograph(const EstimateArguments& arguments, Console* console) {
    return PhotoRun(arguments, console).Run();
}

}  // namespace lacquer::cmd
