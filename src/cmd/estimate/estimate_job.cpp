#include "cmd/estimate/estimate_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cmd/command_support.h"
#include "cmd/estimate/explain.h"
#include "cmd/estimate/material_files.h"
#include "cmd/estimate/photo_inference.h"
#include "cmd/estimate/photo_report.h"
#include "cmd/estimate/posterior_files.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/estimate/report_sentences.h"
#include "cmd/estimate/timed_console.h"
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

std::vector<std::string> HeldOutFamilies(const PhotoSimulator& simulator) {
    std::vector<std::string> families;
    for (const char* family : {"gram", "histogram"})
        if (std::find(simulator.Families().begin(), simulator.Families().end(), family) ==
            simulator.Families().end())
            families.emplace_back(family);
    return families;
}

class Job {
  public:
    Job(const EstimateArguments& arguments, Console* console)
        : a_(arguments),
          console_(console),
          observer_(console, arguments.timeLimit),
          results_{.arguments = arguments} {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        Prepare();
        Console::CatchSignals();
        try {
            Infer();
        } catch (const Interrupted&) {
            return Stopped();
        }
        Write();
        return Finish();
    }

  private:
    /// By a signal, or at the end of the time.
    ExitStatus Stopped() {
        const bool isSignal = Console::Signal() != 0;
        console_->Error(fmt::format("stopped {}; {} has what is done, and --resume goes on",
                                    isSignal ? "by a signal" : "at the end of the time", a_.out));
        if (!isSignal) return ExitStatus::TimeLimit;
        return Console::Signal() == SIGTERM ? ExitStatus::Terminated : ExitStatus::Interrupted;
    }

    // ---- Before the work ----

    void Prepare() {
        if (a_.out.empty()) throw CLI::ValidationError("--out is required: a folder for the results");
        ModelOf(a_);
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
        CheckSampler(a_, results_.Simulator().Parameters(), results_.kinds.size());
        if (!a_.truth.empty()) results_.truth = ReadTruth(a_.truth, results_.Simulator());
        ApplyTone(settings.tone, results_.photo.linear, &results_.image);
        observed_ = results_.Simulator().SummariesOf(results_.image);
        CheckOutputFolder(a_.out);
        MakeOutputFolder(a_.out);
        CheckConfig();
    }

    void MakeSimulators(PhotoSettings settings) {
        std::vector<std::string> families = a_.summaries;
        if (settings.vgg && std::find(families.begin(), families.end(), "vgg") == families.end()) {
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

    Json Config() const {
        const FileBytes bytes = ReadFileBytes(a_.photo, {}, {.maxBytes = size_t(4) << 30});
        return ConfigOf(a_, results_.Simulator(), results_.photo, bytes.View());
    }

    /// A folder with another run in it is not written over; --resume goes on with the same one.
    void CheckConfig() {
        const std::string path = a_.out + "/config.json", log = RunLogName();
        std::error_code ignored;
        const bool isThere = std::filesystem::exists(path, ignored);
        if (!a_.resume) {
            if (std::filesystem::exists(log, ignored))
                throw FileError(log,
                                "holds the simulations of another run: --resume goes on with it; without "
                                "this file the work begins anew");
        } else if (isThere) {
            CheckSameConfig(path, Config());
        } else {
            console_->Info(fmt::format("there is no {}: beginning anew", path));
        }
        WriteText(path, JsonText(Config(), 2) + "\n");
    }
    std::string RunLogName() const { return a_.out + "/runs.bin"; }

    // ---- The work ----

    void Infer() {
        Json settings = Config();
        settings.erase("photo");  // its hash tells
        results_.posterior =
            InferFromSummaries({a_, results_.kinds, observed_, JsonText(settings), &observer_});
        if (a_.mapOnly) return;
        const ParameterSpace& space = results_.Simulator().Parameters();
        results_.summary = Summarize(space, results_.posterior.chains, results_.posterior.mode,
                                     Hash(a_.seed, uint64_t(PhotoResults::Products)));
        std::unique_ptr<PhotoSimulator> heldOut;
        if (const std::vector<std::string> families = HeldOutFamilies(results_.Simulator());
            !families.empty())
            heldOut = SimulatorOf(a_, results_.Simulator().Settings(), families);
        results_.predictive = PredictAndCheck(results_.Simulator(), heldOut.get(), results_.image,
                                              results_.posterior.chains.Natural(space), kNumPredictions,
                                              Hash(a_.seed, uint64_t(PhotoResults::Predictions)), &observer_);
    }

    // ---- After it ----

    void Write() {
        if (!a_.mapOnly) {
            WriteChains(a_.out, results_.Simulator(), a_, results_.posterior.chains,
                        results_.predictive.summaries, observed_);
            WriteSummary(a_.out, results_.summary);
        }
        WriteMode(a_.out, results_.Simulator(), results_.posterior.mode);
        if (results_.kinds.size() > 1) WriteKinds();
        if (a_.explain) Explain();
        WriteMaterialFiles(a_.out, MaterialOf(a_, results_.Simulator(), results_.posterior.mode,
                                              Hash(a_.seed, uint64_t(PhotoResults::Maps))));
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

    ExitStatus Finish() {
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
                fmt::format("warning: the model misses the photograph by {:.2g} of its own deviations; the "
                            "intervals are that much wider",
                            results_.posterior.tau));
        if (a_.mapOnly || (results_.posterior.hasMeanSettled && results_.summary.HasConverged()))
            return ExitStatus::Complete;
        console_->Error(fmt::format(
            "not converged: {}; the results are there, but do not rely on them",
            results_.posterior.hasMeanSettled
                ? fmt::format("R-hat {:.3f} and effective size {:.0f}, expected at most {} and at least {}",
                              results_.summary.maxRhat, results_.summary.minEss, kWorstRhat, kMinEss)
                : fmt::format("the last wave moved the means by {:.2g} deviations, expected less than {:.2g}",
                              results_.posterior.waves.back().shift, results_.posterior.allowedShift)));
        return ExitStatus::NotConverged;
    }

    const EstimateArguments& a_;
    Console* console_;
    TimedConsole observer_;
    PhotoResults results_;
    Vector observed_;
};

}  // namespace

ExitStatus EstimateFromPhotograph(const EstimateArguments& arguments, Console* console) {
    return Job(arguments, console).Run();
}

}  // namespace lacquer::cmd
