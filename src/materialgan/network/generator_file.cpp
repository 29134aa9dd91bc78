#include "materialgan/network/generator_file.h"

#include <fmt/format.h>

#include "materialgan/network/torch_render.h"

namespace lacquer::materialgan {

GeneratorFile LoadGeneratorFile(const std::string& path) {
    const SafetensorsFile file(path);
    if (file.Metadata().contains("training"))
        throw FileError(path, "is the state of a training; its generator is the file beside it");
    GeneratorFile g;
    g.path = path;
    g.config = GeneratorConfig::FromMetadata(file.Metadata(), path);
    g.generator = ReadTensors(file, GeneratorTensors(g.config));
    const std::array latent{size_t(g.config.latentSize)};
    g.meanW = ReadTensor(file, kMeanW, latent);
    g.deviationW =
        file.Has(kDeviationW) ? ReadTensor(file, kDeviationW, latent) : torch::ones({g.config.latentSize});
    if (!(g.deviationW > 0).all().item<bool>())
        throw FileError(path,
                        fmt::format("has tensor \"{}\" with numbers that are not above 0", kDeviationW));
    const std::vector<int> resolutions = g.config.NoiseResolutions();
    for (int i = 0; i < g.config.NumLayers(); ++i) {
        const auto res = size_t(resolutions[size_t(i)]);
        const std::array<size_t, 4> shape{1, 1, res, res};
        const std::string name = FixedNoiseName(i);
        g.noise.push_back(file.Has(name) ? ReadTensor(file, name, shape)
                                         : torch::zeros({1, 1, int64_t(res), int64_t(res)}));
    }
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
