#include "materialgan/training/trainer.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "materialgan/procedural/procedural.h"

namespace lacquer::materialgan {
namespace {

constexpr double kRate = 2e-3, kFirstRate = 0.05, kLastRate = 0.02, kFallAfter = 0.6, kGradientLimit = 1;
constexpr double kNumWarmSteps = 50, kNumPriorSteps = 600, kPriorAfter = 0.25, kMaxAveraging = 0.999;
constexpr const char* kTrainingFormat = "lacquer-training";
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

/// Generator's and encoder's parameters in one order.
std::vector<Tensor> AllParameters(const StyleGenerator& generator, const MapEncoder& encoder) {
    std::vector<Tensor> all;
    for (const auto& [name, tensor] : generator.Parameters()) all.push_back(tensor);
    for (const auto& [name, tensor] : encoder.Parameters()) all.push_back(tensor);
    return all;
}

std::vector<TensorSpec> AllTensors(const GeneratorConfig& config) {
    std::vector<TensorSpec> all = GeneratorTensors(config);
    const std::vector<TensorSpec> encoder = EncoderTensors(config);
    all.insert(all.end(), encoder.begin(), encoder.end());
    return all;
}

/// The tensors of one state, whose names have a prefix.
TensorMap ReadPrefixed(const SafetensorsFile& file, const std::string& prefix,
                       const std::vector<TensorSpec>& specs) {
    TensorMap map;
    for (const TensorSpec& spec : specs)
        map.emplace(spec.name, ReadTensor(file, prefix + spec.name, spec.shape));
    return map;
}

template <class Number>
Number MetadataNumber(const SafetensorsFile& file, const std::string& key) {
    const auto found = file.Metadata().find(key);
    Number value = 0;
    if (found != file.Metadata().end()) {
        const std::string& text = found->second;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size() && value >= 0) return value;
    }
    throw FileError(file.Path(), fmt::format("does not say \"{}\" as a number", key));
}

}  // namespace

Tensor TrainingBatch(int size, int64_t count, uint64_t seed, int64_t first) {
    std::vector<Tensor> maps;
    for (int64_t i = 0; i < count; ++i)
        maps.push_back(ToTensor(TrainingMaterial(size, Hash(seed, uint64_t(first + i)))));
    return torch::stack(maps);
}

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
      adam_(AllParameters(generator_, encoder_), kTrainingAdam) {
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
        throw std::runtime_error(fmt::format("the loss is not finite at step {}", step));
    loss.total.backward();
    adam_.ClipGradients(kGradientLimit);
    adam_.Step(RateAt(step, fraction));
    UpdateAverage();
    loss.total = loss.total.detach();
    return loss;
}

void Trainer::UpdateAverage() {
    const torch::NoGradGuard noGradients;
    const double step = double(NumSteps()), keep = std::min(kMaxAveraging, step / (step + 10));
    for (const TensorMap* map : {&generator_.Parameters(), &encoder_.Parameters()})
        for (const auto& [name, tensor] : *map) average_.at(name).mul_(keep).add_(tensor, 1 - keep);
}

void Trainer::Save(const std::string& path) const {
    std::vector<NamedTensor> tensors;
    AppendTensors(generator_.Parameters(), "now.", &tensors);
    AppendTensors(encoder_.Parameters(), "now.", &tensors);
    AppendTensors(average_, "average.", &tensors);
    Adam& adam = const_cast<Adam&>(adam_);
    for (size_t i = 0; i < adam.Parameters().size(); ++i) {
        tensors.push_back(ToNamedTensor(fmt::format("adam.first{}", i), adam.FirstMoments()[i]));
        tensors.push_back(ToNamedTensor(fmt::format("adam.second{}", i), adam.SecondMoments()[i]));
    }
    auto metadata = config_.ToMetadata();
    metadata["training"] = kTrainingFormat;
    metadata["recipe"] = kProceduralRecipe;
    metadata["batch"] = fmt::format("{}", batch_);
    metadata["seed"] = fmt::format("{}", seed_);
    metadata["steps"] = fmt::format("{}", NumSteps());
    metadata["seconds"] = fmt::format("{}", seconds);
    WriteSafetensors(path, tensors, metadata);
}

Trainer Trainer::Load(const std::string& path) {
    const SafetensorsFile file(path);
    const auto training = file.Metadata().find("training");
    if (training == file.Metadata().end() || training->second != kTrainingFormat)
        throw FileError(path, "is no state of a training");
    const auto recipe = file.Metadata().find("recipe");
    if (recipe == file.Metadata().end() || recipe->second != kProceduralRecipe)
        throw FileError(path, fmt::format("was trained on other materials than \"{}\"", kProceduralRecipe));
    const GeneratorConfig config = GeneratorConfig::FromMetadata(file.Metadata(), path);
    const int batch = MetadataNumber<int>(file, "batch");
    if (batch < 1) throw FileError(path, "has a batch of no images");
    Trainer trainer(config, batch, MetadataNumber<uint64_t>(file, "seed"),
                    ReadPrefixed(file, "now.", GeneratorTensors(config)),
                    ReadPrefixed(file, "now.", EncoderTensors(config)));
    trainer.average_ = ReadPrefixed(file, "average.", AllTensors(config));
    Adam& adam = trainer.adam_;
    for (size_t i = 0; i < adam.Parameters().size(); ++i) {
        std::vector<size_t> shape;
        for (const int64_t n : adam.Parameters()[i].sizes()) shape.push_back(size_t(n));
        adam.FirstMoments()[i] = ReadTensor(file, fmt::format("adam.first{}", i), shape);
        adam.SecondMoments()[i] = ReadTensor(file, fmt::format("adam.second{}", i), shape);
    }
    adam.SetNumSteps(MetadataNumber<int64_t>(file, "steps"));
    trainer.seconds = MetadataNumber<double>(file, "seconds");
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
    file.notes = {{"source", "ladder variational autoencoder on procedural materials"},
                  {"recipe", kProceduralRecipe},
                  {"seed", fmt::format("{}", seed_)},
                  {"steps", fmt::format("{}", NumSteps())},
                  {"images", fmt::format("{}", NumImages())}};
    return file;
}

}  // namespace lacquer::materialgan
