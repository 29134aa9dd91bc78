#include "cmd/estimate/estimate_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/estimate/material_files.h"
#include "cmd/estimate/posterior_files.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/estimate/report_sentences.h"
#include "estimate/calibration/simulation_based.h"
#include "estimate/emulator/emulated_posterior.h"
#include "estimate/infer/product_target.h"
#include "estimate/infer/whitened_hmc.h"
#include "estimate/mode/emulated_mode.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using namespace estimate;
using Json = nlohmann::ordered_json;

/// Seeds of what is drawn beside the waves, which take the seed itself.
enum Purpose : uint64_t { Chains = 101, Predictions, Images, Maps, Products };

constexpr int kNumPredictions = 100, kNumModeStarts = 8, kNumShownDraws = 8;

std::vector<std::string> HeldOutFamilies(const PhotoSimulator& simulator) {
    std::vector<std::string> families;
    for (const char* family : {"gram", "histogram"})
        if (std::find(simulator.Families().begin(), simulator.Families().end(), family) ==
            simulator.Families().end())
            families.emplace_back(family);
    return families;
}

/// All that a run has found.
struct Findings {
    EmulatedPosterior posterior;
    PosteriorChains chains;
    Vector mode;
    PosteriorSummary summary;
    PredictiveSummary predictive;
};

class Job {
  public:
    Job(const EstimateArguments& arguments, Console* console) : a_(arguments), console_(console) {}

    ExitStatus Run() {
        const ThreadLimit threads(a_.threads);
        Prepare();
        Console::CatchSignals();
        try {
            Infer();
        } catch (const Interrupted&) {
            console_->Error(fmt::format(
                "stopped by a signal; {}/runs.bin has the simulations that are done, and --resume goes on",
                a_.out));
            return Console::Signal() == SIGTERM ? ExitStatus::Terminated : ExitStatus::Interrupted;
        }
        Write();
        return Finish();
    }

  private:
    // ---- Before the work ----

    void Prepare() {
        if (a_.out.empty()) throw CLI::ValidationError("--out is required: a folder for the results");
        ModelOf(a_);
        photo_ = ReadPhotograph(a_.photo, ReadingOf(a_));
        for (const std::string& note : photo_.notes) console_->Info("note: " + note);
        for (const std::string& warning : photo_.warnings) console_->Warn("warning: " + warning);
        const PhotoSettings settings = PhotoSettingsOf(a_, &photo_);
        if (!a_.size && !a_.distance)
            console_->Info(
                fmt::format("note: the photograph is taken to show {:.4g} cm from {:.4g} cm away; --size and "
                            "--distance say it better",
                            settings.extent, settings.distance));
        simulator_ = SimulatorOf(a_, settings, a_.summaries);
        for (const std::string& warning : simulator_->Warnings()) console_->Warn("warning: " + warning);
        if (const std::vector<std::string> families = HeldOutFamilies(*simulator_); !families.empty())
            heldOut_ = SimulatorOf(a_, settings, families);
        if (!a_.truth.empty()) truth_ = ReadTruth(a_.truth, *simulator_);
        ApplyTone(settings.tone, photo_.linear, &image_);
        observed_ = simulator_->SummariesOf(image_);
        CheckOutputFolder(a_.out);
        MakeOutputFolder(a_.out);
        CheckConfig();
    }

    Json Config() const {
        const FileBytes bytes = ReadFileBytes(a_.photo, {}, {.maxBytes = size_t(4) << 30});
        return ConfigOf(a_, *simulator_, photo_, bytes.View());
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

    EmulationOptions Emulation() const {
        EmulationOptions options;
        options.seed = a_.seed;
        return options;
    }

    void Infer() {
        const ParameterSpace& space = simulator_->Parameters();
        RunLog log(RunLogName(), Eigen::Index(space.Size()), observed_.size());
        const Runs prior = RunPrior(*simulator_, Emulation(), &log, console_);
        found_.posterior = EmulatePosterior(*simulator_, observed_, prior, Emulation(), &log, console_);
        RunChains(space);
        found_.mode = FindMode(space, *found_.posterior.target,
                               ThinnedColumns(found_.posterior.draws.y, kNumModeStarts));
        found_.summary = Summarize(space, found_.chains, found_.mode, Hash(a_.seed, uint64_t(Products)));
        found_.predictive = PredictAndCheck(*simulator_, heldOut_.get(), image_, found_.chains.Natural(space),
                                            kNumPredictions, Hash(a_.seed, uint64_t(Predictions)), console_);
    }

    /// Hamiltonian chains on the emulator, in coordinates in which its walks are round and products are
    /// straight.
    void RunChains(const ParameterSpace& space) {
        const ProductTarget target(space, *found_.posterior.target);
        const WhitenedHmc hmc(target, target.FromLogits(found_.posterior.draws.y),
                              Hash(a_.seed, uint64_t(Chains)), uint64_t(a_.warmup));
        const auto numSteps = uint64_t(a_.warmup) + uint64_t(a_.samples);
        found_.chains.states = hmc.Start(size_t(a_.chains));
        console_->Begin("chains", int64_t(numSteps) * a_.chains, "steps");
        found_.chains.draws = hmc.Run(numSteps, &found_.chains.states, console_);
        console_->End();
        for (std::vector<Draw>& draws : found_.chains.draws) {
            if (draws.size() < numSteps) throw Interrupted{};
            draws.erase(draws.begin(), draws.begin() + std::ptrdiff_t(a_.warmup));
            for (Draw& draw : draws) draw.y = target.ToLogits(draw.y);
        }
    }

    // ---- After it ----

    void Write() {
        WriteChains(a_.out, *simulator_, a_, found_.chains, found_.predictive.summaries, observed_);
        WriteSummary(a_.out, found_.summary);
        WriteMode(a_.out, *simulator_, found_.mode);
        WriteMaterial();
        WriteReport();
    }

    void WriteMaterial() {
        EstimatedMaterial material;
        material.model = std::string(simulator_->Model().Name());
        const PhotoSettings& settings = simulator_->Settings();
        material.grid = settings.Grid();
        if (a_.mapSize > 0) material.grid.size = a_.mapSize;
        if (a_.mapExtent > 0) {
            material.grid.extent = a_.mapExtent;
            material.grid.isPeriodic = simulator_->Model().CanTile();
        }
        const std::vector<double> parameters = simulator_->AllParameters(found_.mode);
        material.surface = MakeSurface(simulator_->Model(), material.grid, settings.kinds, parameters,
                                       Hash(a_.seed, uint64_t(Maps)));
        const auto value = [&](const char* wanted) {
            return parameters[size_t(simulator_->Model().Find(wanted))];
        };
        material.flash = {value("light"), value("vig"), value("axis_x"), value("axis_y")};
        material.distance = settings.distance;
        WriteMaterialFiles(a_.out, material);
    }

    /// The photograph as a page shows it: values after the tone curve.
    static Image Shown(const PlanarImage& image) {
        Image shown({image.size, image.size}, {"R", "G", "B"});
        for (int y = 0; y < image.size; ++y)
            for (int x = 0; x < image.size; ++x)
                for (int c = 0; c < 3; ++c)
                    shown.Set({x, y}, c,
                              float(image.Channel(size_t(c))[size_t(y) * size_t(image.size) + size_t(x)]));
        return shown;
    }

    void WriteReport() {
        EstimateReport report;
        report.model = a_.model;
        report.title =
            fmt::format("{} from {}", a_.model, std::filesystem::path(a_.photo).filename().string());
        report.command = a_.command;
        const PhotoSettings& settings = simulator_->Settings();
        report.settings = {
            {"Method", fmt::format("emulated, {} simulations", found_.posterior.numRuns)},
            {"Photograph", fmt::format("{0} x {0} pixels, {1:.4g} cm wide, from {2:.4g} cm",
                                       settings.resolution, settings.extent, settings.distance)},
            {"Draws", fmt::format("{} chains of {}", a_.chains, a_.samples)},
            {"Seed", std::to_string(a_.seed)}};
        AddParameters(&report);
        report.numSummaries = size_t(observed_.size());
        report.misfit = found_.posterior.waves.back().misfit;
        report.tau = found_.posterior.tau;
        report.hasMeanSettled = found_.posterior.hasConverged;
        report.clipped = photo_.clipped;
        report.black = photo_.black;
        report.isGrey = photo_.isGray;
        for (const std::vector<Draw>& draws : found_.chains.draws)
            for (const Draw& draw : draws) report.numDivergent += draw.isDivergent;
        for (const std::string& warning : simulator_->Warnings()) report.warnings.push_back(warning + ".");
        report.checks = found_.predictive.checks;
        report.residuals = found_.predictive.residuals;
        report.numPredicted = int(found_.predictive.summaries.rows());
        for (const WaveReport& wave : found_.posterior.waves)
            report.waves.push_back({double(wave.runs), report.waves.empty() ? kUnknown : wave.shift,
                                    wave.misfit, wave.acceptance, wave.maxRhat});
        AddImages(&report);
        WriteEstimateReport(a_.out, report);
    }

    /// What fits into a sentence: without what follows about units and conventions.
    static std::string ShortMeaning(std::string_view meaning) {
        for (const char* rest : {";", ", alpha"}) meaning = meaning.substr(0, meaning.find(rest));
        return std::string(meaning);
    }

    void AddParameters(EstimateReport* report) const {
        report->parameters = found_.summary.parameters;
        const auto truthOf = [&](const std::string& name) {
            const auto truth = truth_.find(name);
            return truth == truth_.end() ? std::optional<double>() : truth->second;
        };
        for (EstimateParameter& p : report->parameters) {
            if (p.factors.empty()) {
                const size_t place = size_t(simulator_->Model().Find(p.name));
                p.meaning = ShortMeaning(simulator_->Model().Parameters()[place].meaning);
            }
            p.truth = truthOf(p.name);
            if (p.factors.size() == 2 && truthOf(p.factors[0]) && truthOf(p.factors[1]))
                p.truth = *truthOf(p.factors[0]) * *truthOf(p.factors[1]);
        }
    }

    void AddImages(EstimateReport* report) const {
        report->photo = Shown(image_);
        report->best = Shown(simulator_->Photograph(found_.mode, Hash(a_.seed, uint64_t(Images))));
        const Matrix draws = ThinnedColumns(found_.chains.Natural(simulator_->Parameters()), kNumShownDraws);
        for (Eigen::Index k = 0; k < draws.cols(); ++k)
            report->draws.push_back(
                Shown(simulator_->Photograph(draws.col(k), Hash(a_.seed, uint64_t(Images), k + 1))));
        const std::filesystem::path folder = std::filesystem::path(a_.out) / "maps";
        for (const auto& [name, unit, isColor] : {std::tuple("albedo", "", true),
                                                  {"f0", "", true},
                                                  {"normal", "", false},
                                                  {"flake_normal", "", false},
                                                  {"rough", "", false},
                                                  {"roughx", "", false},
                                                  {"roughy", "", false},
                                                  {"height", "cm", false}}) {
            const std::string path = (folder / (std::string(name) + ".exr")).string();
            std::error_code ignored;
            if (std::filesystem::exists(path, ignored))
                report->maps.push_back({name, unit, isColor, ReadImage(path, {}, {})});
        }
    }

    ExitStatus Finish() {
        for (const std::string& line : SummaryLines(found_.summary)) console_->Info(line);
        console_->Info(fmt::format("{}: {} simulations; misfit {:.2f} for each summary", a_.out,
                                   found_.posterior.numRuns, found_.posterior.waves.back().misfit));
        if (found_.posterior.tau > 1)
            console_->Warn(
                fmt::format("warning: the model misses the photograph by {:.2g} of its own deviations; the "
                            "intervals are that much wider",
                            found_.posterior.tau));
        if (!found_.posterior.hasConverged || !found_.summary.HasConverged()) {
            console_->Error(fmt::format(
                "not converged: {}; the results are there, but do not rely on them",
                found_.posterior.hasConverged
                    ? fmt::format(
                          "R-hat {:.3f} and effective size {:.0f}, expected at most {} and at least {}",
                          found_.summary.maxRhat, found_.summary.minEss, kWorstRhat, kMinEss)
                    : fmt::format(
                          "the last wave moved the means by {:.2g} deviations, expected less than {:g}",
                          found_.posterior.waves.back().shift, Emulation().tolerance)));
            return ExitStatus::NotConverged;
        }
        return ExitStatus::Complete;
    }

    const EstimateArguments& a_;
    Console* console_;
    PhotographFile photo_;
    PlanarImage image_;  ///< the photograph after the tone curve
    std::unique_ptr<PhotoSimulator> simulator_, heldOut_;
    Vector observed_;
    std::map<std::string, double> truth_;
    Findings found_;
};

}  // namespace

ExitStatus EstimateFromPhotograph(const EstimateArguments& arguments, Console* console) {
    return Job(arguments, console).Run();
}

}  // namespace lacquer::cmd
