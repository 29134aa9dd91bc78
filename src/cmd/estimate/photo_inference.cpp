#include "cmd/estimate/photo_inference.h"

#include <fmt/format.h>

#include "cmd/estimate/purpose.h"
#include "estimate/emulator/emulated_posterior.h"
#include "estimate/infer/kind_evidence.h"
#include "estimate/infer/mala.h"
#include "estimate/infer/population.h"
#include "estimate/infer/product_target.h"
#include "estimate/infer/whitened_hmc.h"
#include "estimate/mode/emulated_mode.h"

namespace lacquer::cmd {

using namespace estimate;

namespace {

EmulatedPosterior Emulate(const InferenceTask& task, size_t kind, const EmulationOptions& options) {
    const PhotoSimulator& simulator = *task.kinds[kind];
    RunLog log(task.RunLogName(kind), Eigen::Index(simulator.Parameters().Size()), task.observed.size());
    const Runs prior = RunPrior(simulator, options, &log, task.observer);
    return EmulatePosterior(simulator, task.observed, prior, options, &log, task.observer);
}

/// Chains on the emulator, in coordinates in which its walks are round and products are straight.
PosteriorChains RunOnEmulator(const InferenceTask& task, const EmulatedPosterior& posterior) {
    const EstimateArguments& a = task.arguments;
    const ProductTarget target(task.Space(), *posterior.target);
    const WhitenedSampler sampler(target, target.FromLogits(posterior.draws.y),
                                  MakeSampler(a, Hash(a.seed, uint64_t(Purpose::PhotoChains))));
    PosteriorChains chains = RunCheckpointed(
        task, [&] { return sampler.Start(size_t(a.chains)); },
        [&](uint64_t numSteps, std::vector<ChainState>* states) {
            return sampler.Run(numSteps, states, task.observer);
        });
    for (std::vector<Draw>& draws : chains.draws)
        for (Draw& draw : draws) draw.y = target.ToLogits(draw.y);
    return chains;
}

const std::vector<std::unique_ptr<PhotoSimulator>>& KindSimulators(const InferenceTask& task) {
    return task.kindSummaries ? task.kindSummaries->simulators : task.kinds;
}

PhotoPosterior InferByEmulation(const InferenceTask& task) {
    constexpr int kNumModeStarts = 8, kRunsPerKind = 1500;
    EmulationOptions options;
    options.seed = task.arguments.seed;
    std::vector<EmulatedPosterior> posteriors;
    std::vector<KindPosterior> kinds;
    Eigen::Index numRuns = 0;
    for (size_t k = 0; k < task.kinds.size(); ++k) {
        posteriors.push_back(Emulate(task, k, options));
        numRuns += posteriors.back().numRuns;
        kinds.push_back({KindSimulators(task)[k].get(), posteriors.back().draws.y});
    }
    PhotoPosterior found;
    found.kindProbabilities =
        KindProbabilities(kinds, task.kindSummaries ? task.kindSummaries->observed : task.observed,
                          kRunsPerKind, Hash(options.seed, uint64_t(Purpose::Kinds)), task.observer);
    if (kinds.size() > 1) numRuns += kRunsPerKind * Eigen::Index(kinds.size());
    found.kind = size_t(std::max_element(found.kindProbabilities.begin(), found.kindProbabilities.end()) -
                        found.kindProbabilities.begin());
    const EmulatedPosterior& best = posteriors[found.kind];
    found.method =
        fmt::format("{}, {} simulations", task.arguments.mapOnly ? "mode, emulated" : "emulated", numRuns);
    if (!task.arguments.mapOnly) found.chains = RunOnEmulator(task, best);
    found.mode = FindMode(task.Space(), *best.target, ThinnedColumns(best.draws.y, kNumModeStarts));
    found.misfit = best.waves.back().misfit;
    found.tau = best.tau;
    found.hasMeanSettled = best.hasConverged;
    found.allowedShift = best.waves.back().allowedShift;
    for (const WaveReport& wave : best.waves)
        found.waves.push_back({double(wave.runs), found.waves.empty() ? kUnknown : wave.shift, wave.misfit,
                               wave.acceptance, wave.maxRhat});
    return found;
}

}  // namespace

std::string InferenceTask::RunLogName(size_t kind) const {
    return kind == 0 ? arguments.out + "/runs.bin" : fmt::format("{}/runs-{}.bin", arguments.out, kind + 1);
}

std::unique_ptr<const estimate::Sampler> MakeSampler(const EstimateArguments& a, uint64_t seed) {
    // Of the published rule's steps in coordinates of unit covariance.
    constexpr double kPublishedDelta = 0.1;
    const auto warmup = uint64_t(a.warmup);
    if (a.sampler == "mala") return std::make_unique<Mala>(seed, warmup);
    if (a.sampler == "mala-published")
        return std::make_unique<MalaAfterPublished>(seed, warmup, kPublishedDelta);
    // Steps on an emulator cost next to nothing, and its ridges bend in their tails.
    if (a.method == "emulated")
        return std::make_unique<Hmc>(seed, warmup, Hmc::Options{.maxLeapfrog = 16, .targetAcceptance = 0.95});
    return std::make_unique<Hmc>(seed, warmup, Hmc::Options());
}

PhotoPosterior InferFromSummaries(const InferenceTask& task) {
    return task.arguments.method == "fixed-seed" ? InferWithFixedSeeds(task) : InferByEmulation(task);
}

}  // namespace lacquer::cmd
