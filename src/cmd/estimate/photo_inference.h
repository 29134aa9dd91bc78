// The methods of `lacquer estimate`: from summaries of a photograph to a posterior.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cmd/estimate/estimate_arguments.h"
#include "cmd/estimate/posterior_summary.h"

namespace lacquer::cmd {

/// Where chains are kept until all results are written.
inline std::string CheckpointName(const EstimateArguments& arguments) {
    return arguments.out + "/checkpoint.json";
}

/// What tells kinds apart.
struct KindSummaries {
    std::vector<std::unique_ptr<estimate::PhotoSimulator>> simulators;  ///< of the task's kinds
    estimate::Vector observed;
};

/// What a method works on.
struct InferenceTask {
    const EstimateArguments& arguments;
    /// Simulators of one model that differ in the kinds of cells and noise only; at least one.
    const std::vector<std::unique_ptr<estimate::PhotoSimulator>>& kinds;
    const estimate::Vector& observed;
    std::string settings;  ///< those that a checkpoint must have
    Observer* observer;
    /// Of more summaries than parameters are estimated by; null: of the same.
    const KindSummaries* kindSummaries = nullptr;

    const estimate::ParameterSpace& Space() const { return kinds[0]->Parameters(); }
    /// Of simulations: runs.bin, runs-2.bin ...
    std::string RunLogName(size_t kind) const;
};

/// What a method has found.
struct PhotoPosterior {
    std::string method;                     ///< for people: "emulated, 5050 simulations"
    size_t kind = 0;                        ///< the most probable one of the task's
    std::vector<double> kindProbabilities;  ///< of all of them; empty: not known
    PosteriorChains chains;                 ///< no chains if only the mode was asked for
    estimate::Vector mode;                  ///< most probable parameters, natural units
    double misfit = kUnknown;               ///< there or at the mean, over the number of summaries
    double tau = 1;                         ///< by which deviations were widened because of it
    std::vector<EstimateWave> waves;        ///< of the emulated method
    double allowedShift = kUnknown;         ///< by which the last wave may move the means, in deviations
    bool hasMeanSettled = true;             ///< it moved them by less
};

/// Errors: estimate::Interrupted if the observer asks to stop; what was done is kept in the files above.
PhotoPosterior InferFromSummaries(const InferenceTask& task);

/// Usage error, if --sampler cannot move what is to be estimated.
void CheckSampler(const EstimateArguments& arguments, const estimate::ParameterSpace& space, size_t numKinds);

/// By K fixed seeds: the mode alone with --map-only, else chains that start around it.
PhotoPosterior InferWithFixedSeeds(const InferenceTask& task);

/// The sampler that --sampler names, or HMC. @param seed  of its random numbers
std::unique_ptr<const estimate::Sampler> MakeSampler(const EstimateArguments& arguments, uint64_t seed);

/// Chains that are written down now and then and when they are done, so that an interrupted computation goes
/// on where it was.
/// @param start    states of all chains, if there is no checkpoint to go on with
/// @param advance  (number of steps, states): draws made until all chains have that many steps
/// @return         all draws without those of warm-up, and where the chains ended. Errors: Interrupted,
///                 FileError
PosteriorChains RunCheckpointed(const InferenceTask& task,
                                const std::function<std::vector<estimate::ChainState>()>& start,
                                const std::function<std::vector<std::vector<estimate::Draw>>(
                                    uint64_t, std::vector<estimate::ChainState>*)>& advance);

}  // namespace lacquer::cmd
