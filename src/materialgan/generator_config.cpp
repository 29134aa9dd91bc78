#include "materialgan/generator_config.h"

#include <fmt/format.h>

#include <charconv>

#include "pbrt/core/error.h"

namespace lacquer::materialgan {
namespace {

constexpr int kColourChannels = 9;

/// The field `name` as a number in [low, high]. Errors: FileError.
double ConfigField(const std::map<std::string, std::string>& metadata, const std::string& path,
                   const std::string& name, double low, double high) {
    const auto found = metadata.find(name);
    if (found == metadata.end()) throw FileError(path, fmt::format("does not say \"{}\"", name));
    const std::string& text = found->second;
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
        throw FileError(path, fmt::format("says \"{}\" is \"{}\", and a number from {} to {} is needed", name,
                                          Excerpt(text), low, high));
    return value;
}

int WholeField(const std::map<std::string, std::string>& metadata, const std::string& path,
               const std::string& name, int low, int high) {
    const double value = ConfigField(metadata, path, name, low, high);
    if (value != double(int(value)))
        throw FileError(path, fmt::format("says \"{}\" is {}, and a whole number is needed", name, value));
    return int(value);
}

void AddStyled(const std::string& name, size_t kernel, size_t in, size_t out, size_t latent,
               std::vector<TensorSpec>* tensors) {
    tensors->push_back({name + ".weight", {kernel, kernel, in, out}});
    tensors->push_back({name + ".bias", {out}});
    tensors->push_back({name + ".style.fc.weight", {in, latent}});
    tensors->push_back({name + ".style.bias", {in}});
}

}  // namespace

int GeneratorConfig::NumFeatureMaps(int res) const { return std::max(1, std::min(mapsBase / res, mapsMax)); }

int GeneratorConfig::NumLayers() const { return int(NoiseResolutions().size()); }

std::vector<int> GeneratorConfig::Resolutions() const {
    std::vector<int> resolutions;
    for (int res = 4; res <= resolution; res *= 2) resolutions.push_back(res);
    return resolutions;
}

std::vector<int> GeneratorConfig::NoiseResolutions() const {
    std::vector<int> resolutions;
    for (const int res : Resolutions()) resolutions.insert(resolutions.end(), res == 4 ? 1 : 2, res);
    return resolutions;
}

std::map<std::string, std::string> GeneratorConfig::ToMetadata() const {
    return {{"format", kGeneratorFormat},
            {"resolution", fmt::format("{}", resolution)},
            {"fmapsBase", fmt::format("{}", mapsBase)},
            {"fmapsMax", fmt::format("{}", mapsMax)},
            {"wDim", fmt::format("{}", latentSize)},
            {"mappingLayers", fmt::format("{}", mappingLayers)},
            {"lrMultiplier", fmt::format("{}", lrMultiplier)},
            {"roughnessMin", fmt::format("{}", roughnessRange[0])},
            {"roughnessMax", fmt::format("{}", roughnessRange[1])}};
}

GeneratorConfig GeneratorConfig::FromMetadata(const std::map<std::string, std::string>& metadata,
                                              const std::string& path) {
    const auto format = metadata.find("format");
    if (format == metadata.end() || format->second != kGeneratorFormat)
        throw FileError(
            path, fmt::format("is no generator: its format is \"{}\", and \"{}\" is needed",
                              format == metadata.end() ? "" : Excerpt(format->second), kGeneratorFormat));
    GeneratorConfig c;
    c.resolution = WholeField(metadata, path, "resolution", kMinResolution, kMaxResolution);
    if ((c.resolution & (c.resolution - 1)) != 0)
        throw FileError(path, fmt::format("has resolution {}, which is no power of two", c.resolution));
    c.mapsBase = WholeField(metadata, path, "fmapsBase", 1, kMaxMaps * kMaxResolution);
    c.mapsMax = WholeField(metadata, path, "fmapsMax", 1, kMaxMaps);
    c.latentSize = WholeField(metadata, path, "wDim", 1, kMaxLatent);
    c.mappingLayers = WholeField(metadata, path, "mappingLayers", 1, 32);
    c.lrMultiplier = ConfigField(metadata, path, "lrMultiplier", 1e-6, 1);
    c.roughnessRange = {ConfigField(metadata, path, "roughnessMin", -1, 1),
                        ConfigField(metadata, path, "roughnessMax", -1, 1)};
    if (!(c.roughnessRange[0] < c.roughnessRange[1]))
        throw FileError(path, fmt::format("has roughness from {} to {}, and the first must be smaller",
                                          c.roughnessRange[0], c.roughnessRange[1]));
    return c;
}

std::string LayerName(int layer) { return fmt::format("synthesis.layer{}", layer); }
std::string OutputName(int output) { return fmt::format("synthesis.output{}", output); }
std::string DenseName(int layer) { return fmt::format("mapping.dense{}", layer); }
std::string FixedNoiseName(int layer) { return LayerName(layer) + ".noise"; }

std::vector<TensorSpec> GeneratorTensors(const GeneratorConfig& config) {
    const auto latent = size_t(config.latentSize);
    std::vector<TensorSpec> tensors;
    for (int i = 0; i < config.mappingLayers; ++i) {
        tensors.push_back({DenseName(i) + ".fc.weight", {latent, latent}});
        tensors.push_back({DenseName(i) + ".bias", {latent}});
    }
    const auto maps = [&](int res) { return size_t(config.NumFeatureMaps(res)); };
    tensors.push_back({"synthesis.early_layer.const", {1, maps(4), 4, 4}});
    const std::vector<int> resolutions = config.NoiseResolutions();
    for (int i = 0; i < config.NumLayers(); ++i) {
        const int res = resolutions[size_t(i)], from = i % 2 == 1 ? res / 2 : res;
        AddStyled(LayerName(i), 3, maps(from), maps(res), latent, &tensors);
        tensors.push_back({LayerName(i) + ".noise_strength", {}});
        if (i % 2 == 0) AddStyled(OutputName(i / 2), 1, maps(res), kColourChannels, latent, &tensors);
    }
    return tensors;
}

}  // namespace lacquer::materialgan
