#include "materialgan/training/gan_trainer.h"

#include <fmt/format.h>

#include <cmath>

#include "materialgan/procedural/procedural.h"
#include "materialgan/train.h"
#include "materialgan/training/gan_losses.h"
#include "pbrt/core/rng.h"

namespace lacquer::materialgan {
namespace {

constexpr double kGanRate = 2e-3, kGanBeta2 = 0.99, kPenaltyGamma = 10, kPathDecay = 0.99;
/// Steps from one penalty to the next, of the discriminator and of the generator.
constexpr int64_t kPenaltyEvery = 16, kPathEvery = 8;
/// Images after which the average has forgotten half of the weights, and steps at the start that count alike.
constexpr double kHalfLife = 10000, kFirstAverage = 10;
constexpr double kMaxPathLength = 1e12;

/// A penalty at every k-th step only, k times as strong, with rate and moments as if k + 1 steps were one of
/// each kind: c = k / (k + 1), rate c, beta^c [Karras et al. 2020], appendix B. beta1 is 0.
double LazyShare(int64_t every) { return double(every) / double(every + 1); }
AdamOptions LazyAdam(int64_t every) { return {.beta1 = 0, .beta2 = std::pow(kGanBeta2, LazyShare(every))}; }

void RequireGradients(const Adam& adam, bool isRequired) {
    for (Tensor parameter : adam.Parameters()) parameter.requires_grad_(isRequired);
}

/// @return the value. Errors: TrainingError.
double FiniteLoss(const Tensor& loss, const char* whose, int64_t step) {
    const double value = loss.item<double>();
    if (!std::isfinite(value))
        throw TrainingError(fmt::format("the loss of the {} is not finite at step {}", whose, step));
    return value;
}

}  // namespace

GanTrainer::GanTrainer(const GeneratorConfig& config, int batch, uint64_t seed)
    : GanTrainer(config, batch, seed,
                 RandomGeneratorParameters(config, SeededGenerator(Hash(seed, uint64_t(1)))),
                 RandomDiscriminatorParameters(config, SeededGenerator(Hash(seed, uint64_t(2))))) {}

GanTrainer::GanTrainer(const GeneratorConfig& config, int batch, uint64_t seed, TensorMap generator,
                       TensorMap discriminator)
    : config_(config),
      batch_(batch),
      seed_(seed),
      generator_(config, std::move(generator)),
      discriminator_(config, std::move(discriminator)),
      adamG_(ParametersOf({&generator_.Parameters()}), LazyAdam(kPathEvery)),
      adamD_(ParametersOf({&discriminator_.Parameters()}), LazyAdam(kPenaltyEvery)) {
    for (const auto& [name, tensor] : generator_.Parameters())
        average_.emplace(name, tensor.detach().clone());
}

GanLoss GanTrainer::Step() {
    StepDiscriminator();
    StepGenerator();
    UpdateAverage();
    return last_;
}

void GanTrainer::StepDiscriminator() {
    const int64_t step = NumSteps();
    const Tensor real = TrainingBatch(config_.resolution, batch_, seed_, step * batch_);
    torch::Generator random = SeededGenerator(Hash(seed_, uint64_t(3), step));
    Tensor fake;
    {
        const torch::NoGradGuard noGradients;
        const Tensor styles = MixedStyles(generator_, batch_, random);
        fake = generator_.Synthesize(styles, generator_.RandomNoise(batch_, random));
    }
    Tensor loss = DiscriminatorLoss(discriminator_.Judge(real), discriminator_.Judge(fake));
    last_.discriminator = FiniteLoss(loss, "discriminator", step);
    if (step % kPenaltyEvery == 0) {
        const Tensor penalty = GradientPenalty(discriminator_, real);
        last_.gradientPenalty = FiniteLoss(penalty, "discriminator's gradient", step);
        loss = loss + double(kPenaltyEvery) * kPenaltyGamma * penalty;
    }
    loss.backward();
    adamD_.Step(LazyShare(kPenaltyEvery) * kGanRate);
}

void GanTrainer::StepGenerator() {
    const int64_t step = NumSteps();
    torch::Generator random = SeededGenerator(Hash(seed_, uint64_t(4), step));
    // The discriminator only judges here.
    RequireGradients(adamD_, false);
    const Tensor styles = MixedStyles(generator_, batch_, random);
    const Tensor fake = generator_.Synthesize(styles, generator_.RandomNoise(batch_, random));
    Tensor loss = GeneratorLoss(discriminator_.Judge(fake));
    last_.generator = FiniteLoss(loss, "generator", step);
    if (step % kPathEvery == 0) {
        const Tensor penalty = PathPenalty(random);
        FiniteLoss(penalty, "generator's paths", step);
        loss = loss + double(kPathEvery) * PathLengthWeight(config_.resolution) * penalty;
    }
    loss.backward();
    adamG_.Step(LazyShare(kPathEvery) * kGanRate);
    RequireGradients(adamD_, true);
}

/// [Karras et al. 2020], eq. 4: what path lengths are off their moving mean. Of half of a batch, for memory.
Tensor GanTrainer::PathPenalty(torch::Generator random) {
    const int64_t count = std::max(1, batch_ / 2);
    const Tensor w = generator_.Map(NormalNumbers({count, config_.latentSize}, random));
    const Tensor lengths = PathLengths(generator_, w, random);
    last_.pathLength = lengths.detach().mean().item<double>();
    meanPathLength_ += (1 - kPathDecay) * (last_.pathLength - meanPathLength_);
    return (lengths - meanPathLength_).square().mean();
}

void GanTrainer::UpdateAverage() {
    const double step = double(NumSteps());
    const double keep = std::min(std::pow(0.5, batch_ / kHalfLife), step / (step + kFirstAverage));
    MoveAverage(generator_.Parameters(), keep, &average_);
}

void GanTrainer::Save(const std::string& path) const {
    std::vector<NamedTensor> tensors;
    AppendTensors(generator_.Parameters(), "now.", &tensors);
    AppendTensors(discriminator_.Parameters(), "now.", &tensors);
    AppendTensors(average_, "average.", &tensors);
    AppendAdam(adamG_, "adam.", &tensors);
    AppendAdam(adamD_, "discriminator.adam.", &tensors);
    auto metadata =
        TrainingHeader{kGanTrainingFormat, config_, batch_, seed_, NumSteps(), seconds}.ToMetadata();
    metadata["meanPathLength"] = fmt::format("{}", meanPathLength_);
    WriteSafetensors(path, tensors, metadata);
}

GanTrainer GanTrainer::Load(const std::string& path) {
    const SafetensorsFile file(path);
    const TrainingHeader header = TrainingHeader::Read(file, kGanTrainingFormat);
    const GeneratorConfig& config = header.config;
    GanTrainer trainer(config, header.batch, header.seed,
                       ReadPrefixed(file, "now.", GeneratorTensors(config)),
                       ReadPrefixed(file, "now.", DiscriminatorTensors(config)));
    trainer.average_ = ReadPrefixed(file, "average.", GeneratorTensors(config));
    ReadAdam(file, "adam.", &trainer.adamG_);
    ReadAdam(file, "discriminator.adam.", &trainer.adamD_);
    trainer.adamG_.SetNumSteps(header.steps);
    trainer.adamD_.SetNumSteps(header.steps);
    trainer.meanPathLength_ = StoredNumber(file, "meanPathLength", kMaxPathLength);
    trainer.seconds = header.seconds;
    return trainer;
}

GeneratorFile GanTrainer::Average(int numMaterials) const {
    const torch::NoGradGuard noGradients;
    GeneratorFile file;
    file.config = config_;
    for (const auto& [name, tensor] : average_) file.generator.emplace(name, tensor.clone());
    const StyleGenerator generator(config_, file.generator);
    const Tensor z = NormalNumbers({std::max(2, numMaterials), config_.latentSize},
                                   SeededGenerator(Hash(seed_, uint64_t(5))));
    const Tensor w = generator.Map(z);
    file.meanW = w.mean(0);
    file.deviationW = w.std(0, /*unbiased=*/false).clamp_min(1e-4);
    file.noise = generator.ZeroNoise(1);
    file.notes =
        TrainingNotes("adversarial training on procedural materials", seed_, NumSteps(), NumImages());
    return file;
}

}  // namespace lacquer::materialgan
