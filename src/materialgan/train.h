// Training from its start, or from where it stopped, to a file.
#pragma once

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>

#include "materialgan/generator_config.h"
#include "pbrt/core/progress.h"

namespace lacquer::materialgan {

/// What a generator is trained for.
enum class TrainingObjective {
    Autoencoder,  ///< to be the decoder of one, with an encoder that comes along
    Gan           ///< to pass for materials with a discriminator [Goodfellow et al. 2014]
};

struct TrainOptions {
    TrainingObjective objective = TrainingObjective::Autoencoder;
    std::string out;  ///< the generator; its state goes beside it (TrainingStatePath())
    GeneratorConfig config;
    double hours = 0;   ///< of work, that of earlier runs included; 0: by steps
    int64_t steps = 0;  ///< all of them, those of earlier runs included; 0: by hours
    int batch = 16;
    uint64_t seed = 1;
    bool resume = false;
    int threads = 1;
    double checkpointSeconds = 60, previewSeconds = 900;
    int statisticsMaterials = 1024;
};

/// The most materials a step, for memory: 2^24 texels.
constexpr int MaxBatch(int resolution) { return std::min(4096, (1 << 24) / (resolution * resolution)); }

struct TrainProgress {
    int64_t step = 0, images = 0;
    double fraction = 0, seconds = 0;
    TrainingObjective objective = TrainingObjective::Autoencoder;
    // Means since the last report.
    double reconstruction = 0, klZ = 0, klNoise = 0, rmse = 0;        ///< of an autoencoder
    double generatorLoss = 0, discriminatorLoss = 0, pathLength = 0;  ///< of a GAN
};

/// A loss that is not finite: the state in memory is good no longer, the one that was stored last is.
class TrainingError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// "x.safetensors" has its state in "x.training.safetensors" and its preview in "x.preview.png".
std::string TrainingStatePath(const std::string& out);
std::string TrainingPreviewPath(const std::string& out);

/// Trains until steps or hours are over, or the observer wants to stop; the generator is written then, and at
/// each preview. A state is stored every `checkpointSeconds` and at the end; with `resume` the training goes
/// on from there with the bits it would have had, if it goes by steps. Objective, configuration, batch and
/// seed are then those of the state.
/// @return  false if it was stopped
/// Errors: FileError; TrainingError.
bool Train(const TrainOptions& options, Observer& observer,
           const std::function<void(const TrainProgress&)>& report);

}  // namespace lacquer::materialgan
