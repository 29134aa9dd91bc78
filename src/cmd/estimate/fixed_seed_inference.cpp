// Fixed seeds: the mode, and chains around it.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>

#include "cmd/estimate/photo_inference.h"
#include "cmd/estimate/purpose.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/mixed_chain.h"
#include "estimate/infer/population.h"
#include "estimate/infer/whitened_hmc.h"
#include "estimate/mode/find_modes.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

/// Of each kind its target and its modes, with one covariance for all.
class FixedSeedPosterior {
  public:
    explicit FixedSeedPosterior(const InferenceTask& task) : task_(task), a_(task.arguments) {
        options_.tau = 1;
        options_.seeds.clear();
        for (int k = 0; k < a_.seeds; ++k)
            options_.seeds.push_back(Hash(a_.seed, uint64_t(Purpose::FixedSeeds), k));
        options_.countsOwnScatter = !HandError(a_);
        FindPilot();
        MakeTargets();
        for (const auto& target : targets_) modes_.push_back(BestMode(*target, Search()));
        best_ = size_t(std::min_element(modes_.begin(), modes_.end(),
                                        [](const Mode& a, const Mode& b) { return a.energy < b.energy; }) -
                       modes_.begin());
        Inflate();
    }

    PhotoPosterior Report() const {
        PhotoPosterior found;
        found.method = fmt::format("{} {} fixed seed{}", a_.mapOnly ? "mode by" : "chains with", a_.seeds,
                                   a_.seeds == 1 ? "" : "s");
        found.kind = best_;
        found.mode = task_.Space().ToNatural(modes_[best_].y);
        found.misfit = modes_[best_].misfit;
        found.tau = options_.tau;
        return found;
    }
    PosteriorChains SmoothChains() const;
    PosteriorChains MixedChains() const;

  private:
    ModeOptions Search() const {
        ModeOptions search;
        search.seed = Hash(a_.seed, uint64_t(Purpose::Modes));
        return search;
    }
    Mode BestMode(const FixedSeedTarget& target, const ModeOptions& search) const {
        // Steps of Adam, which the simulator's gradients make; and what Ceres does is not counted.
        task_.observer->Begin("mode", int64_t(search.numStarts) * search.adamSteps, "steps");
        std::vector<Mode> modes = FindModes(target, search, task_.observer);
        task_.observer->End();
        if (task_.observer->ShouldStop()) throw Interrupted{};
        return modes.front();
    }
    /// The covariance belongs to the place where the mode is: a short search with that of the prior's middle
    /// finds the place.
    void FindPilot() {
        constexpr Eigen::Index kRuns = 200;
        const ParameterSpace& space = task_.Space();
        if (const auto error = HandError(a_)) {
            scatter_ = ScatterByHand(task_.observed.size(), *error);
            return;
        }
        Vector middle{Eigen::Index(space.Size())};
        for (size_t i = 0; i < space.Size(); ++i) middle[Eigen::Index(i)] = space[i].prior.Quantile(0.5);
        const PhotoSimulator& simulator = *task_.kinds[0];
        const uint64_t seed = Hash(a_.seed, uint64_t(Purpose::Scatter));
        scatter_ = MeasureScatter(simulator, middle, kRuns, seed);
        FixedSeedTarget::Options one = options_;
        one.seeds.resize(1);
        ModeOptions search = Search();
        search.adamSteps /= 2;
        search.numStarts = 2;
        search.maxIterations = 5;
        const Mode pilot = BestMode(FixedSeedTarget(simulator, task_.observed, scatter_, one), search);
        scatter_ = MeasureScatter(simulator, space.ToNatural(pilot.y), kRuns, seed + 1);
    }
    /// Photographs are no samples of the model: a misfit that is too large widens the posterior.
    void Inflate() {
        constexpr double kMaxMisfit = 1.5;
        const auto count = double(targets_[best_]->NumSummaries());
        const double free = count - double(task_.Space().Size());
        if (HandError(a_) || !(modes_[best_].misfit > kMaxMisfit) || free < 1) return;
        options_.tau = std::sqrt(modes_[best_].misfit * count / free);
        MakeTargets();
    }
    void MakeTargets() {
        targets_.clear();
        for (const auto& kind : task_.kinds)
            targets_.push_back(std::make_unique<FixedSeedTarget>(*kind, task_.observed, scatter_, options_));
    }

    const InferenceTask& task_;
    const EstimateArguments& a_;
    FixedSeedTarget::Options options_;
    SummaryScatter scatter_;
    std::vector<std::unique_ptr<FixedSeedTarget>> targets_;
    std::vector<Mode> modes_;
    size_t best_ = 0;
};

/// Where all parameters have derivatives of use: the sampler that was asked for, from over-dispersed starts
/// around the mode.
PosteriorChains FixedSeedPosterior::SmoothChains() const {
    constexpr double kDispersion = 1.5;
    const FixedSeedTarget& target = *targets_[best_];
    const Vector& mode = modes_[best_].y;
    const Matrix root = kDispersion * CholeskyFactor(CovarianceAt(target, mode));
    Matrix sample(mode.size(), 50 * mode.size());
    for (Eigen::Index i = 0; i < sample.cols(); ++i) {
        Random random(a_.seed, uint64_t(Purpose::Starts), uint64_t(i));
        sample.col(i) = mode + root * random.Normals(mode.size());
    }
    const WhitenedSampler sampler(target, sample,
                                  MakeSampler(a_, Hash(a_.seed, uint64_t(Purpose::FixedSeedChains))));
    return RunCheckpointed(
        task_, [&] { return sampler.Start(size_t(a_.chains)); },
        [&](uint64_t numSteps, std::vector<ChainState>* states) {
            return sampler.Run(numSteps, states, task_.observer);
        });
}

/// Algorithm 1, where some have none, or where kinds are to be told.
PosteriorChains FixedSeedPosterior::MixedChains() const {
    MixedTarget target;
    for (const auto& kind : targets_) target.kinds.push_back(kind.get());
    for (const estimate::Parameter& parameter : task_.Space().All())
        target.isSmooth.push_back(parameter.smooth);
    const MixedChain chain(Hash(a_.seed, uint64_t(Purpose::FixedSeedChains)), uint64_t(a_.warmup));
    const auto start = [&] {
        constexpr double kDispersion = 0.1;
        std::vector<ChainState> states;
        for (int c = 0; c < a_.chains; ++c) {
            const size_t kind = size_t(c) % modes_.size();
            Random random(a_.seed, uint64_t(Purpose::Starts), uint64_t(c));
            const Vector& mode = modes_[kind].y;
            states.push_back(chain.Start(target, mode + kDispersion * random.Normals(mode.size()), kind));
        }
        return states;
    };
    return RunCheckpointed(task_, start, [&](uint64_t numSteps, std::vector<ChainState>* states) {
        return chain.Run(target, numSteps, states, task_.observer);
    });
}

/// A parameter whose derivatives are of no use, or nothing.
std::string FirstRough(const ParameterSpace& space) {
    for (const estimate::Parameter& parameter : space.All())
        if (!parameter.smooth) return parameter.name;
    return "";
}

}  // namespace

void CheckSampler(const EstimateArguments& a, const ParameterSpace& space, size_t numKinds) {
    if (a.method != "fixed-seed" || a.mapOnly || a.sampler.empty() || a.sampler == "mala") return;
    const std::string rough = FirstRough(space);
    if (rough.empty() && numKinds == 1) return;
    throw CLI::ValidationError(
        fmt::format("--sampler {}: {} has no derivative with fixed seeds; expected mala", a.sampler,
                    rough.empty() ? "the kind" : rough));
}

PhotoPosterior InferWithFixedSeeds(const InferenceTask& task) {
    const bool isMixed = !FirstRough(task.Space()).empty() || task.kinds.size() > 1;
    const FixedSeedPosterior posterior(task);
    PhotoPosterior found = posterior.Report();
    if (task.arguments.mapOnly) return found;
    found.chains = isMixed ? posterior.MixedChains() : posterior.SmoothChains();
    if (task.kinds.size() == 1) return found;
    found.kindProbabilities.assign(task.kinds.size(), 0);
    double count = 0;
    for (const std::vector<Draw>& chain : found.chains.draws)
        for (const Draw& draw : chain) found.kindProbabilities[size_t(draw.kind)] += 1, ++count;
    for (double& probability : found.kindProbabilities) probability /= count;
    found.kind = size_t(std::max_element(found.kindProbabilities.begin(), found.kindProbabilities.end()) -
                        found.kindProbabilities.begin());
    return found;
}

}  // namespace lacquer::cmd
