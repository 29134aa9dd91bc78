#include "cmd/estimate/layered_job.h"

#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/estimate/estimate_run.h"
#include "cmd/estimate/layered_report.h"
#include "cmd/estimate/photo_inference.h"
#include "cmd/estimate/posterior_files.h"
#include "cmd/estimate/posterior_summary.h"
#include "cmd/estimate/purpose.h"
#include "cmd/estimate/report_sentences.h"
#include "cmd/version.h"
#include "estimate/infer/population.h"
#include "estimate/infer/product_target.h"
#include "estimate/infer/whitened_hmc.h"
#include "estimate/mode/emulated_mode.h"
#include "estimate/scene/scene_material_file.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

using namespace estimate;
using Json = nlohmann::ordered_json;

constexpr int kNumMaterialDraws = 8;

class LayeredRun final : public EstimateRun {
  public:
    using EstimateRun::EstimateRun;

  private:
    void Prepare() override {
        problem_ = ReadLayeredScene(a_, console_);
        ReadData(a_, &problem_);
        if (!a_.candidates.empty()) candidates_ = ReadDirections(a_.candidates);
        if (!a_.truth.empty()) truth_ = ReadTruth(a_.truth, *problem_.space, "measurement");
        observed_ = problem_.Observed();
        if (const std::string doubt = problem_.photograph ? "" : Doubt(problem_.measurement); !doubt.empty())
            console_->Warn("warning: " + doubt);
        if (problem_.photograph) console_->Warn(std::string("warning: ") + kPhotographWarning);
        for (const estimate::Parameter& p : problem_.space->All())
            if (!p.productWith.empty())
                console_->Info(
                    fmt::format("note: {} and {} matter by their product alone, the optical thickness: "
                                "it is told, and neither of them beyond its prior",
                                p.name, p.productWith));
    }

    Json MakeConfig() const override {
        const FileBytes bytes = ReadFileBytes(a_.photo, {}, {.maxBytes = size_t(4) << 30});
        Json config;
        config["by"] = fmt::format("Lacquer {}", kVersion);
        config["photo"] = a_.photo;
        config["data_hash"] = HashText(bytes.View());
        config["scene"] = a_.scene;
        const std::string material = MaterialText(problem_.parameters->With(problem_.parameters->Start()),
                                                  problem_.parameters->Needed());
        config["material_hash"] = HashText(material);
        config["material"] = problem_.parameters->Material();
        config["priors"] = PriorsOf(*problem_.space);
        config["robust"] = a_.robust;
        config["sampler"] = a_.sampler;
        AddChainSettings(a_, &config);
        return config;
    }

    // ---- The work ----

    void Infer() override {
        const LobeOptions options = LobeOptionsOf(a_);
        RunLog log(RunLogName(), Eigen::Index(problem_.parameters->Space().Size()),
                   Eigen::Index(problem_.Simulator().SummaryNames().size()));
        const Runs prior = RunLobePrior(problem_.Simulator(), options, &log, &observer_);
        posterior_ = FindLobePosterior(problem_.Simulator(), *problem_.space, *problem_.coordinates,
                                       observed_, prior, options, &log, &observer_);
        if (problem_.IsExact())
            exact_ = std::make_unique<ExactLobeTarget>(problem_.Simulator(), *problem_.space, observed_,
                                                       a_.robust, posterior_.target.get());
        chains_ = RunChains();
        constexpr int kNumModeStarts = 8;
        mode_ =
            FindMode(*problem_.space, *posterior_.target, ThinnedColumns(posterior_.draws.y, kNumModeStarts));
        summary_ =
            Summarize(*problem_.space, chains_, mode_, Hash(a_.seed, uint64_t(Purpose::LayeredProducts)));
        next_ = RankCandidates();
    }

    const Target& TargetOfChains() const {
        if (exact_) return *exact_;
        return *posterior_.target;
    }

    /// Chains in coordinates in which the walks of the last wave are round.
    PosteriorChains RunChains() {
        const ProductTarget target(*problem_.space, TargetOfChains());
        const WhitenedSampler sampler(target, target.FromLogits(posterior_.draws.y),
                                      MakeSampler(a_, Hash(a_.seed, uint64_t(Purpose::LayeredChains))));
        const std::vector<std::unique_ptr<PhotoSimulator>> none;
        const InferenceTask task{a_, none, observed_.logs, Settings(), &observer_};
        PosteriorChains chains = RunCheckpointed(
            task, [&] { return sampler.Start(size_t(a_.chains)); },
            [&](uint64_t numSteps, std::vector<ChainState>* states) {
                return sampler.Run(numSteps, states, &observer_);
            });
        for (std::vector<Draw>& draws : chains.draws)
            for (Draw& draw : draws) draw.y = target.ToLogits(draw.y);
        return chains;
    }

    /// Reflectances in the directions that could be measured next, at some draws of the posterior, by common
    /// random numbers.
    std::vector<NextDirection> RankCandidates() {
        constexpr int kDraws = 64;
        if (!problem_.reflectance || !problem_.measurement.IsColor()) return {};
        const SceneReflectance there = problem_.reflectance->At(candidates_);
        const Matrix draws = WithoutNoise(ThinnedColumns(chains_.Logits(), kDraws));
        Matrix predicted(kDraws, there.NumValues());
        observer_.Begin("candidates", kDraws, "");
        ParallelFor(kDraws, [&](int64_t k) {
            const Vector x = problem_.parameters->Space().ToNatural(draws.col(k));
            const Vector all = there.Measure(x, Hash(a_.seed, uint64_t(Purpose::Candidates)), 2);
            predicted.row(k) = FlooredLogs(all.head(there.NumValues()), observed_.floor);
            observer_.Advance(1);
        });
        observer_.End();
        double noise = 0;
        for (const EstimateParameter& p : summary_.parameters)
            if (p.name == kNoiseName) noise = p.mean;
        return RankDirections(candidates_, draws, predicted, noise);
    }

    // ---- After it ----

    Vector WithoutLast(const Vector& x) const { return x.head(x.size() - 1); }
    Vector Predict(const Vector& x) const {
        return exact_ ? exact_->Predict(x) : posterior_.target->Predict(x);
    }

    void Write() override {
        constexpr int kNumPredictedLobes = 200;
        const Matrix draws = ThinnedColumns(chains_.Natural(*problem_.space), kNumPredictedLobes);
        Matrix predicted(draws.cols(), observed_.logs.size());
        for (Eigen::Index k = 0; k < draws.cols(); ++k) predicted.row(k) = Predict(draws.col(k));
        WriteChains(a_.out, *problem_.space, problem_.parameters->Material(), problem_.ValueNames(), a_,
                    chains_, predicted, observed_.logs);
        WriteSummary(a_.out, summary_);
        Json map;
        map["material"] = problem_.parameters->Material();
        for (size_t i = 0; i < problem_.space->Size(); ++i)
            map["parameters"][(*problem_.space)[i].name] = mode_[Eigen::Index(i)];
        WriteText(a_.out + "/map.json", JsonText(map, 2) + "\n");
        WriteMaterial("material.pbrt", mode_);
        const Matrix some = ThinnedColumns(draws, kNumMaterialDraws);
        for (int k = 0; k < kNumMaterialDraws; ++k)
            WriteMaterial(fmt::format("material-{}.pbrt", k + 1), some.col(k));
        WriteEstimateReport(a_.out, ReportOf({.arguments = a_,
                                              .problem = problem_,
                                              .observed = observed_,
                                              .posterior = posterior_,
                                              .chains = chains_,
                                              .summary = summary_,
                                              .predicted = predicted,
                                              .noise = draws.bottomRows(1).transpose(),
                                              .next = next_,
                                              .truth = truth_}));
    }
    void WriteMaterial(const std::string& name, const Vector& x) const {
        WriteText(a_.out + "/" + name,
                  MaterialText(problem_.parameters->With(WithoutLast(x)), problem_.parameters->Needed()));
    }

    ExitStatus Finish() override {
        for (const std::string& line : SummaryLines(summary_)) console_->Info(line);
        console_->Info(fmt::format("{}: {}, {} simulations in {} waves, {} chains", a_.out,
                                   exact_ ? "closed form" : "emulated", posterior_.numRuns,
                                   posterior_.waves.size(), a_.sampler.empty() ? "hmc" : a_.sampler));
        if (!next_.empty()) console_->Info("next measurement: " + NextText(next_));
        const bool hasSettled = exact_ || posterior_.hasConverged;
        if (hasSettled && summary_.HasConverged()) return ExitStatus::Complete;
        return NotConverged(hasSettled, summary_, posterior_.waves.back().shift,
                            posterior_.waves.back().allowedShift);
    }

    LayeredProblem problem_;
    ObservedLobes observed_;
    LobePosterior posterior_;
    std::unique_ptr<ExactLobeTarget> exact_;  ///< null: the model has noise
    PosteriorChains chains_;
    Vector mode_;
    PosteriorSummary summary_;
    std::vector<DirectionAngles> candidates_ = CandidateDirections();
    std::vector<NextDirection> next_;
    std::map<std::string, double> truth_;
};

}  // namespace

ExitStatus EstimateLayers(const EstimateArguments& arguments, Console* console) {
    return LayeredRun(arguments, console).Run();
}

}  // namespace lacquer::cmd
