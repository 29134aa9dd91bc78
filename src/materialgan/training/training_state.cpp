#include "materialgan/training/training_state.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>

#include "materialgan/procedural/procedural.h"
#include "materialgan/train.h"
#include "pbrt/core/rng.h"

namespace lacquer::materialgan {
namespace {

constexpr int64_t kMaxStoredSteps = int64_t(1) << 40;
constexpr double kMaxStoredSeconds = 1e12;

const std::string& StoredText(const SafetensorsFile& file, const std::string& key) {
    static const std::string none;
    const auto found = file.Metadata().find(key);
    return found == file.Metadata().end() ? none : found->second;
}

template <class Number>
Number NumberUpTo(const SafetensorsFile& file, const std::string& key, Number max) {
    const std::string& text = StoredText(file, key);
    Number value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size() && value >= 0 && value <= max) return value;
    throw FileError(file.Path(), fmt::format("says \"{}\" is \"{}\", and a number from 0 to {} is needed",
                                             key, Excerpt(text), max));
}

}  // namespace

std::map<std::string, std::string> TrainingHeader::ToMetadata() const {
    auto metadata = config.ToMetadata();
    metadata["training"] = format;
    metadata["recipe"] = kProceduralRecipe;
    metadata["batch"] = fmt::format("{}", batch);
    metadata["seed"] = fmt::format("{}", seed);
    metadata["steps"] = fmt::format("{}", steps);
    metadata["seconds"] = fmt::format("{}", seconds);
    return metadata;
}

TrainingHeader TrainingHeader::Read(const SafetensorsFile& file, const std::string& format) {
    if (StoredText(file, "training") != format) throw FileError(file.Path(), "is no state of a training");
    if (StoredText(file, "recipe") != kProceduralRecipe)
        throw FileError(file.Path(),
                        fmt::format("was trained on other materials than \"{}\"", kProceduralRecipe));
    TrainingHeader header{format, GeneratorConfig::FromMetadata(file.Metadata(), file.Path())};
    header.batch = NumberUpTo<int>(file, "batch", MaxBatch(header.config.resolution));
    if (header.batch < 1) throw FileError(file.Path(), "has a batch of no images");
    header.seed = NumberUpTo<uint64_t>(file, "seed", std::numeric_limits<uint64_t>::max());
    header.steps = NumberUpTo<int64_t>(file, "steps", kMaxStoredSteps);
    header.seconds = StoredNumber(file, "seconds", kMaxStoredSeconds);
    return header;
}

double StoredNumber(const SafetensorsFile& file, const std::string& key, double max) {
    return NumberUpTo<double>(file, key, max);
}

TensorMap ReadPrefixed(const SafetensorsFile& file, const std::string& prefix,
                       const std::vector<TensorSpec>& specs) {
    TensorMap map;
    for (const TensorSpec& spec : specs)
        map.emplace(spec.name, ReadTensor(file, prefix + spec.name, spec.shape));
    return map;
}

void AppendAdam(const Adam& adam, const std::string& prefix, std::vector<NamedTensor>* tensors) {
    for (size_t i = 0; i < adam.Parameters().size(); ++i) {
        tensors->push_back(ToNamedTensor(fmt::format("{}first{}", prefix, i), adam.FirstMoments()[i]));
        tensors->push_back(ToNamedTensor(fmt::format("{}second{}", prefix, i), adam.SecondMoments()[i]));
    }
}

void ReadAdam(const SafetensorsFile& file, const std::string& prefix, Adam* adam) {
    for (size_t i = 0; i < adam->Parameters().size(); ++i) {
        std::vector<size_t> shape;
        for (const int64_t n : adam->Parameters()[i].sizes()) shape.push_back(size_t(n));
        const std::string second = fmt::format("{}second{}", prefix, i);
        adam->FirstMoments()[i] = ReadTensor(file, fmt::format("{}first{}", prefix, i), shape);
        adam->SecondMoments()[i] = ReadTensor(file, second, shape);
        if ((adam->SecondMoments()[i] < 0).any().item<bool>())
            throw FileError(file.Path(), fmt::format("has tensor \"{}\" with numbers below 0", second));
    }
}

std::vector<Tensor> ParametersOf(std::initializer_list<const TensorMap*> networks) {
    std::vector<Tensor> all;
    for (const TensorMap* network : networks)
        for (const auto& [name, tensor] : *network) all.push_back(tensor);
    return all;
}

void MoveAverage(const TensorMap& now, double keep, TensorMap* average) {
    const torch::NoGradGuard noGradients;
    for (const auto& [name, tensor] : now) average->at(name).mul_(keep).add_(tensor, 1 - keep);
}

std::map<std::string, std::string> TrainingNotes(const std::string& source, uint64_t seed, int64_t steps,
                                                 int64_t images) {
    return {{"source", source},
            {"recipe", kProceduralRecipe},
            {"seed", fmt::format("{}", seed)},
            {"steps", fmt::format("{}", steps)},
            {"images", fmt::format("{}", images)}};
}

Tensor TrainingBatch(int size, int64_t count, uint64_t seed, int64_t first) {
    std::vector<Tensor> maps;
    for (int64_t i = 0; i < count; ++i)
        maps.push_back(ToTensor(TrainingMaterial(size, Hash(seed, uint64_t(first + i)))));
    return torch::stack(maps);
}

}  // namespace lacquer::materialgan
