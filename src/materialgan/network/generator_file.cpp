#include "materialgan/network/generator_file.h"

#include <fmt/format.h>

#include <filesystem>

#include "materialgan/network/torch_render.h"

namespace lacquer::materialgan {
namespace {

constexpr const char* kStartLowW = "start.low.w";
std::string StartLowNoiseName(int layer) { return fmt::format("start.low.noise{}", layer); }

std::vector<size_t> NoiseShape(const GeneratorConfig& config, int layer) {
    const auto res = size_t(config.NoiseResolutions()[size_t(layer)]);
    return {1, 1, res, res};
}

LatentTensors ReadStartLow(const SafetensorsFile& file, const GeneratorConfig& config) {
    const std::array<size_t, 3> shape{1, size_t(config.NumColumns()), size_t(config.latentSize)};
    LatentTensors start{ReadTensor(file, kStartLowW, shape), {}};
    for (int i = 0; i < config.NumLayers(); ++i)
        start.noise.push_back(ReadTensor(file, StartLowNoiseName(i), NoiseShape(config, i)));
    return start;
}

}  // namespace

LatentTensors LatentTensors::Clone() const {
    LatentTensors copy{wPlus.detach().clone(), {}};
    for (const Tensor& map : noise) copy.noise.push_back(map.detach().clone());
    return copy;
}

std::string FileStamp(const std::string& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    const auto time = std::filesystem::last_write_time(path, error);
    return error ? std::string() : fmt::format("{} {}", size, time.time_since_epoch().count());
}

GeneratorFile LoadGeneratorFile(const std::string& path) {
    const std::string stamp = FileStamp(path);
    const SafetensorsFile file(path);
    if (file.Metadata().contains("training"))
        throw FileError(path, "is the state of a training; its generator is the file beside it");
    GeneratorFile g;
    g.path = path;
    g.stamp = stamp;
    g.config = GeneratorConfig::FromMetadata(file.Metadata(), path);
    g.generator = ReadTensors(file, GeneratorTensors(g.config));
    const std::array latent{size_t(g.config.latentSize)};
    g.meanW = ReadTensor(file, kMeanW, latent);
    g.deviationW =
        file.Has(kDeviationW) ? ReadTensor(file, kDeviationW, latent) : torch::ones({g.config.latentSize});
    if (!(g.deviationW > 0).all().item<bool>())
        throw FileError(path,
                        fmt::format("has tensor \"{}\" with numbers that are not above 0", kDeviationW));
    for (int i = 0; i < g.config.NumLayers(); ++i) {
        const std::vector<size_t> shape = NoiseShape(g.config, i);
        const std::string name = FixedNoiseName(i);
        g.noise.push_back(file.Has(name) ? ReadTensor(file, name, shape)
                                         : torch::zeros({1, 1, int64_t(shape[2]), int64_t(shape[3])}));
    }
    if (file.Has(kStartLowW)) g.startLow = ReadStartLow(file, g.config);
    if (file.Has("encoder.input.weight")) g.encoder = ReadTensors(file, EncoderTensors(g.config));
    const auto known = g.config.ToMetadata();
    for (const auto& [key, value] : file.Metadata())
        if (!known.contains(key)) g.notes.emplace(key, value);
    return g;
}

void SaveGeneratorFile(const GeneratorFile& file, const std::string& path, bool half) {
    std::vector<NamedTensor> tensors;
    AppendTensors(file.generator, "", &tensors);
    tensors.push_back(ToNamedTensor(kMeanW, file.meanW));
    tensors.push_back(ToNamedTensor(kDeviationW, file.deviationW));
    for (int i = 0; i < file.config.NumLayers(); ++i)
        tensors.push_back(ToNamedTensor(FixedNoiseName(i), file.noise[size_t(i)]));
    if (file.encoder) AppendTensors(*file.encoder, "", &tensors);
    if (file.startLow) {
        tensors.push_back(ToNamedTensor(kStartLowW, file.startLow->wPlus));
        for (int i = 0; i < file.config.NumLayers(); ++i)
            tensors.push_back(ToNamedTensor(StartLowNoiseName(i), file.startLow->noise[size_t(i)]));
    }
    auto metadata = file.config.ToMetadata();
    metadata.insert(file.notes.begin(), file.notes.end());
    WriteSafetensors(path, tensors, metadata, half);
}

capture::Maps MadeMaps(const GeneratorFile& file, const Tensor& synthesized) {
    if (!synthesized.isfinite().all().item<bool>())
        throw FileError(file.path, "makes maps with numbers that are not finite");
    return ToMaps(ClampMaps(synthesized, file.config));
}

}  // namespace lacquer::materialgan
