#include "cmd/estimate/estimate_run.h"

#include <fmt/format.h>

#include <csignal>
#include <filesystem>

#include "cmd/command_support.h"
#include "cmd/estimate/photo_inference.h"
#include "cmd/estimate/posterior_files.h"
#include "cmd/estimate/report_sentences.h"
#include "estimate/emulator/runs.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {

ExitStatus EstimateRun::Run() {
    const ThreadLimit threads(a_.threads);
    if (a_.out.empty()) throw CLI::ValidationError("--out is required: a folder for the results");
    Prepare();
    PrepareFolder();
    Console::CatchSignals();
    try {
        Infer();
    } catch (const estimate::Interrupted&) {
        return Stopped();
    }
    Write();
    std::error_code ignored;
    if (!a_.mapOnly) std::filesystem::remove(CheckpointName(a_), ignored);
    return Finish();
}

void EstimateRun::PrepareFolder() {
    CheckOutputFolder(a_.out);
    MakeOutputFolder(a_.out);
    config_ = MakeConfig();
    const std::string path = a_.out + "/config.json";
    std::error_code ignored;
    if (!a_.resume) {
        for (const std::string& kept : {RunLogName(), CheckpointName(a_)})
            if (std::filesystem::exists(kept, ignored))
                throw FileError(kept, fmt::format("holds the {} of another run: --resume goes on with it; "
                                                  "without this file the work begins anew",
                                                  kept == RunLogName() ? "simulations" : "chains"));
    } else if (std::filesystem::exists(path, ignored)) {
        CheckSameConfig(path, config_);
    } else {
        console_->Info(fmt::format("there is no {}: beginning anew", path));
    }
    WriteText(path, JsonText(config_, 2) + "\n");
}

std::string EstimateRun::Settings() const {
    nlohmann::ordered_json settings = config_;
    settings.erase("photo");
    return JsonText(settings);
}

ExitStatus EstimateRun::Stopped() const {
    const bool isSignal = Console::Signal() != 0;
    console_->Error(fmt::format("stopped {}; {} has what is done, and --resume goes on",
                                isSignal ? "by a signal" : "at the end of the time", a_.out));
    if (!isSignal) return ExitStatus::TimeLimit;
    return Console::StatusOfSignal();
}

ExitStatus EstimateRun::NotConverged(bool hasSettled, const PosteriorSummary& summary, double shift,
                                     double allowedShift) const {
    // What helps is there with --model and with --scene: --fix, for example, is not.
    std::string why, help;
    if (hasSettled) {
        why = fmt::format("R-hat {:.3f} and effective size {:.0f}, expected at most {} and at least {}",
                          summary.maxRhat, summary.minEss, kWorstRhat, kMinEss);
        help =
            "More --samples and --warmup may help; chains that keep to values of their own, in the report's "
            "plots, need a --prior that rules out all but one of these";
    } else {
        why = fmt::format("the last wave moved the means by {:.2g} deviations, expected less than {:.2g}",
                          shift, allowedShift);
        help =
            "Most often the model cannot look like this: see the fit in the report, and tell what is known "
            "by --prior";
    }
    console_->Error(
        fmt::format("not converged: {}; the results are there, but do not rely on them. {}", why, help));
    return ExitStatus::NotConverged;
}

}  // namespace lacquer::cmd
