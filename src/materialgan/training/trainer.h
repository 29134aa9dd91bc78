// A training as a state that steps forward, and can be stored between any two steps.
#pragma once

#include "materialgan/network/adam.h"
#include "materialgan/network/generator_file.h"
#include "materialgan/training/ladder_vae.h"
#include "materialgan/training/training_state.h"

namespace lacquer::materialgan {

/// What states of this training say that they are.
inline constexpr const char* kTrainingFormat = "lacquer-training";

class Trainer {
  public:
    Trainer(const GeneratorConfig& config, int batch, uint64_t seed);
    /// As it was when it was stored. Errors: FileError, as for generators.
    static Trainer Load(const std::string& path);
    /// Errors: FileError.
    void Save(const std::string& path) const;

    /// Learns from the next batch; which one, and all random numbers, depend on seed and number of the step.
    /// @param fraction  of the training that lies behind; decides on the rate and on the weight of the prior
    /// Errors: TrainingError (train.h) if the loss is not finite; the state is then as it was before.
    LadderLoss Step(double fraction);

    uint64_t Seed() const { return seed_; }
    int64_t NumSteps() const { return adam_.NumSteps(); }
    int64_t NumImages() const { return NumSteps() * batch_; }
    const GeneratorConfig& Config() const { return config_; }
    /// Seconds of work, that of earlier runs included; for schedules by time.
    double seconds = 0;

    /// The average of the weights of late steps, with the statistics of w and noise over `numMaterials`
    /// training materials.
    GeneratorFile Average(int numMaterials) const;

  private:
    Trainer(const GeneratorConfig& config, int batch, uint64_t seed, TensorMap generator, TensorMap encoder);
    void UpdateAverage();

    GeneratorConfig config_;
    int batch_;
    uint64_t seed_;
    StyleGenerator generator_;
    MapEncoder encoder_;
    TensorMap average_;  ///< of generator and encoder, by their names
    Adam adam_;
};

}  // namespace lacquer::materialgan
