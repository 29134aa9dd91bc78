// The other training, of generator and discriminator against each other, as a state that steps forward.
#pragma once

#include "materialgan/network/generator_file.h"
#include "materialgan/training/discriminator.h"
#include "materialgan/training/training_state.h"

namespace lacquer::materialgan {

/// What states of this training say that they are.
inline constexpr const char* kGanTrainingFormat = "lacquer-gan-training";

/// Of one step. Penalties are those of the last step that had them.
struct GanLoss {
    double generator = 0, discriminator = 0;
    double gradientPenalty = 0;  ///< R1, without its weight
    double pathLength = 0;       ///< mean of the batch
};

class GanTrainer {
  public:
    GanTrainer(const GeneratorConfig& config, int batch, uint64_t seed);
    /// As it was when it was stored. Errors: FileError, as for generators.
    static GanTrainer Load(const std::string& path);
    /// Errors: FileError.
    void Save(const std::string& path) const;

    /// A step of the discriminator and one of the generator; which materials, and all random numbers, depend
    /// on seed and number of the step. Errors: TrainingError (train.h) if a loss is not finite; the state is
    /// good no longer then.
    GanLoss Step();

    uint64_t Seed() const { return seed_; }
    int64_t NumSteps() const { return adamG_.NumSteps(); }
    int64_t NumImages() const { return NumSteps() * batch_; }
    double seconds = 0;  ///< of work, that of earlier runs included

    /// The average of the generator's weights, with the statistics of w over `numMaterials` of normal
    /// numbers.
    GeneratorFile Average(int numMaterials) const;

  private:
    GanTrainer(const GeneratorConfig& config, int batch, uint64_t seed, TensorMap generator,
               TensorMap discriminator);
    void StepDiscriminator();
    void StepGenerator();
    Tensor PathPenalty(torch::Generator random);
    void UpdateAverage();

    GeneratorConfig config_;
    int batch_;
    uint64_t seed_;
    StyleGenerator generator_;
    Discriminator discriminator_;
    TensorMap average_;  ///< of the generator
    Adam adamG_, adamD_;
    double meanPathLength_ = 0;
    GanLoss last_;
};

}  // namespace lacquer::materialgan
