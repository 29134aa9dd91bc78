// Descent in the space of latents, for fits to photographs and for embeddings of maps.
#pragma once

#include "materialgan/fit/fit_target.h"
#include "materialgan/fit/latent_codes.h"

namespace lacquer::materialgan {

struct LatentSchedule {
    int iterations = 0;
    int strategy = 2;
    bool movesW = true, movesNoise = true;
    FitOptimizer optimizer = FitOptimizer::Adam;
    double rateW = 0, rateNoise = 0;
    const char* name = "";  ///< for the observer and the checkpoint
    /// The error of photographs for tests, at every so many iterations; may be empty.
    std::function<double(const Tensor& maps)> testRmse = {};
    int testEvery = 0;
    /// After each iteration, before its step, and again for those that a checkpoint has; may be empty.
    std::function<void(const capture::FitStep&)> afterStep = {};
    capture::FitCheckpoint* checkpoint = nullptr;  ///< as capture::FitSettings has it
};

struct LatentDescent {
    LatentTensors latents;
    std::vector<double> losses;  ///< of the iterations
    std::vector<capture::FitStep> steps;
    capture::FitResult::End end = capture::FitResult::End::Finished;
};

/// What is minimised, of maps that are clamped but for a hundredth of the gradient, and of latents.
using LatentObjective =
    std::function<PhotoObjective::Value(const Tensor& maps, const LatentTensors& latents, FitPhase phase)>;

/// @param generator  its kernels should be kept (StyleGenerator::KeepKernels())
/// @param toPlus     makes w+ of what moves; null: w+ itself moves
LatentDescent DescendLatents(const StyleGenerator& generator, const LatentTensors& start,
                             const LatentSchedule& schedule, const LatentObjective& objective,
                             Observer* observer, const std::function<Tensor(const Tensor&)>& toPlus = {});

}  // namespace lacquer::materialgan
