#include "materialgan/training/trainer.h"

#include <fmt/format.h>

#include <cmath>

#include "materialgan/procedural/procedural.h"
#include "materialgan/train.h"
#include "pbrt/core/rng.h"

namespace lacquer::materialgan {
namespace {

constexpr double kRate = 2e-3, kFirstRate = 0.05, kLastRate = 0.02, kFallAfter = 0.6, kGradientLimit = 1;
constexpr double kNumWarmSteps = 50, kNumPriorSteps = 600, kPriorAfter = 0.25, kMaxAveraging = 0.999;
constexpr AdamOptions kTrainingAdam{.beta2 = 0.99};

/// Up during the first steps, and down over the last two fifths.
double RateAt(int64_t step, double fraction) {
    const double up = std::min(1., double(step) / kNumWarmSteps + kFirstRate);
    return kRate * up * std::clamp((1 - fraction) / (1 - kFallAfter), kLastRate, 1.);
}

/// The weight of the prior rises to 1 by a quarter of the training, or earlier.
double PriorWeightAt(int64_t step, double fraction) {
    return std::min(1., std::max(double(step) / kNumPriorSteps, fraction / kPriorAfter));
}

std::vector<TensorSpec> AllTensors(const GeneratorConfig& config) {
    std::vector<TensorSpec> all = GeneratorTensors(config);
    const std::vector<TensorSpec> encoder = EncoderTensors(config);
    all.insert(all.end(), encoder.begin(), encoder.end());
    return all;
}

}  // namespace

Trainer::Trainer(const GeneratorConfig& config, int batch, uint64_t seed)
    : Trainer(config, batch, seed,
              RandomGeneratorParameters(config, SeededGenerator(Hash(seed, uint64_t(1)))),
              RandomEncoderParameters(config, SeededGenerator(Hash(seed, uint64_t(2))))) {}

Trainer::Trainer(const GeneratorConfig& config, int batch, uint64_t seed, TensorMap generator,
                 TensorMap encoder)
    : config_(config),
      batch_(batch),
      seed_(seed),
      generator_(config, std::move(generator)),
      encoder_(config, std::move(encoder)),
      adam_(ParametersOf({&generator_.Parameters(), &encoder_.Parameters()}), kTrainingAdam) {
    for (const TensorMap* map : {&generator_.Parameters(), &encoder_.Parameters()})
        for (const auto& [name, tensor] : *map) average_.emplace(name, tensor.detach().clone());
}

LadderLoss Trainer::Step(double fraction) {
    const int64_t step = NumSteps();
    const Tensor maps = TrainingBatch(config_.resolution, batch_, seed_, step * batch_);
    torch::Generator random = SeededGenerator(Hash(seed_, uint64_t(3), step));
    LadderLoss loss =
        EvaluateLadder(generator_, encoder_, maps, PriorWeightAt(step, fraction), std::move(random));
    if (!std::isfinite(loss.total.item<double>()))
        throw TrainingError(fmt::format("the loss is not finite at step {}", step));
    loss.total.backward();
    adam_.ClipGradients(kGradientLimit);
    adam_.Step(RateAt(step, fraction));
    UpdateAverage();
    loss.total = loss.total.detach();
    return loss;
}

void Trainer::UpdateAverage() {
    const double step = double(NumSteps()), keep = std::min(kMaxAveraging, step / (step + 10));
    for (const TensorMap* map : {&generator_.Parameters(), &encoder_.Parameters()})
        MoveAverage(*map, keep, &average_);
}

void Trainer::Save(const std::string& path) const {
    std::vector<NamedTensor> tensors;
    AppendTensors(generator_.Parameters(), "now.", &tensors);
    AppendTensors(encoder_.Parameters(), "now.", &tensors);
    AppendTensors(average_, "average.", &tensors);
    AppendAdam(adam_, "adam.", &tensors);
    WriteSafetensors(
        path, tensors,
        TrainingHeader{kTrainingFormat, config_, batch_, seed_, NumSteps(), seconds}.ToMetadata());
}

Trainer Trainer::Load(const std::string& path) {
    const SafetensorsFile file(path);
    const TrainingHeader header = TrainingHeader::Read(file, kTrainingFormat);
    const GeneratorConfig& config = header.config;
    Trainer trainer(config, header.batch, header.seed, ReadPrefixed(file, "now.", GeneratorTensors(config)),
                    ReadPrefixed(file, "now.", EncoderTensors(config)));
    trainer.average_ = ReadPrefixed(file, "average.", AllTensors(config));
    ReadAdam(file, "adam.", &trainer.adam_);
    trainer.adam_.SetNumSteps(header.steps);
    trainer.seconds = header.seconds;
    return trainer;
}

GeneratorFile Trainer::Average(int numMaterials) const {
    const torch::NoGradGuard noGradients;
    GeneratorFile file;
    file.config = config_;
    TensorMap encoder;
    for (const auto& [name, tensor] : average_)
        (name.starts_with("encoder.") ? encoder : file.generator).emplace(name, tensor.clone());
    const StyleGenerator generator(config_, file.generator);
    const MapEncoder mapEncoder(config_, encoder);
    // The posterior over all materials, rather than the prior: that is where materials are.
    constexpr int kAtOnce = 32;
    torch::Generator random = SeededGenerator(Hash(seed_, uint64_t(4)));
    std::vector<Tensor> columns, noise = generator.ZeroNoise(1);
    const int numBatches = std::max(1, numMaterials / kAtOnce);
    for (int i = 0; i < numBatches; ++i) {
        const Tensor maps =
            TrainingBatch(config_.resolution, kAtOnce, Hash(seed_, uint64_t(5)), int64_t(i) * kAtOnce);
        const LatentSample sample = SampleLatents(mapEncoder.Encode(maps), random);
        columns.push_back(generator.Map(sample.z));
        for (size_t j = 0; j < noise.size(); ++j)
            noise[j] += sample.noise[j].mean(0, /*keepdim=*/true) / double(numBatches);
    }
    const Tensor w = torch::cat(columns);
    file.meanW = w.mean(0);
    file.deviationW = w.std(0, /*unbiased=*/false).clamp_min(1e-4);
    file.noise = std::move(noise);
    file.encoder = std::move(encoder);
    file.notes = TrainingNotes("ladder variational autoencoder on procedural materials", seed_, NumSteps(),
                               NumImages());
    return file;
}

}  // namespace lacquer::materialgan
