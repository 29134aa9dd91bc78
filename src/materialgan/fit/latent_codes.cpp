#include "materialgan/fit/latent_codes.h"

#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

Tensor TensorOf(const std::vector<float>& values, torch::IntArrayRef shape) {
    Tensor tensor = torch::empty(shape, torch::kFloat);
    LACQUER_CHECK(size_t(tensor.numel()) == values.size());
    std::ranges::copy(values, tensor.data_ptr<float>());
    return tensor;
}

}  // namespace

LatentTensors ToTensors(const Latents& latents, const GeneratorConfig& config) {
    LatentTensors tensors{TensorOf(latents.wPlus, {1, config.NumColumns(), config.latentSize}), {}};
    const std::vector<int> resolutions = config.NoiseResolutions();
    LACQUER_CHECK(latents.noise.size() == resolutions.size());
    for (size_t i = 0; i < resolutions.size(); ++i)
        tensors.noise.push_back(TensorOf(latents.noise[i], {1, 1, resolutions[i], resolutions[i]}));
    return tensors;
}

Latents FromTensors(const LatentTensors& tensors) {
    Latents latents{ToNamedTensor("", tensors.wPlus).values, {}};
    for (const Tensor& map : tensors.noise) latents.noise.push_back(ToNamedTensor("", map).values);
    return latents;
}

LatentTensors MeanLatents(const GeneratorFile& file) {
    const GeneratorConfig& c = file.config;
    LatentTensors latents{file.meanW.expand({1, c.NumColumns(), c.latentSize}).clone(), {}};
    for (const int res : c.NoiseResolutions()) latents.noise.push_back(torch::zeros({1, 1, res, res}));
    return latents;
}

LatentTensors EncodedLatents(const GeneratorFile& file, const Tensor& maps) {
    const torch::NoGradGuard noGradients;
    LACQUER_CHECK(file.encoder.has_value());
    const StyleGenerator generator(file.config, file.generator);
    Encoding e = MapEncoder(file.config, *file.encoder).Encode(maps);
    LatentTensors latents{generator.Repeat(generator.Map(e.zMean)).clone(), {}};
    for (const Tensor& map : e.noiseMean) latents.noise.push_back(map.clone());
    return latents;
}

}  // namespace lacquer::materialgan
