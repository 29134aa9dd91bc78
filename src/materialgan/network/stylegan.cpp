#include "materialgan/network/stylegan.h"

#include <cmath>

#include "materialgan/network/upsampling.h"
#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

constexpr double kStyleSlope = 0.2, kStyleEpsilon = 1e-8, kStartStrength = 0.3;
const double kStyleGain = std::sqrt(2.0);

Tensor Activate(const Tensor& x) { return torch::leaky_relu(x, kStyleSlope) * kStyleGain; }

bool DoublesResolution(int layer) { return layer % 2 == 1; }

}  // namespace

StyleGenerator::StyleGenerator(const GeneratorConfig& config, TensorMap parameters)
    : config_(config), parameters_(std::move(parameters)) {
    for (const TensorSpec& spec : GeneratorTensors(config)) LACQUER_CHECK(parameters_.contains(spec.name));
}

Tensor StyleGenerator::Map(const Tensor& z) const {
    Tensor x = z * torch::rsqrt(z.square().mean(1, /*keepdim=*/true) + kStyleEpsilon);
    const double rate = config_.lrMultiplier;
    for (int i = 0; i < config_.mappingLayers; ++i) {
        const Tensor& weights = At(DenseName(i) + ".fc.weight");
        x = torch::matmul(x, weights.t()) * (rate / std::sqrt(double(weights.size(1)))) +
            At(DenseName(i) + ".bias") * rate;
        x = Activate(x);
    }
    return x;
}

Tensor StyleGenerator::Synthesize(const Tensor& wPlus, const std::vector<Tensor>& noise) const {
    LACQUER_CHECK(int(noise.size()) == config_.NumLayers() && wPlus.size(1) == config_.NumColumns());
    Tensor x = At("synthesis.early_layer.const").expand({wPlus.size(0), -1, -1, -1});
    Tensor image;
    for (int layer = 0; layer < config_.NumLayers(); ++layer) {
        x = Layer(layer, x, wPlus.select(1, layer), noise[size_t(layer)]);
        if (DoublesResolution(layer)) continue;
        const Tensor output = Output(layer / 2, x, wPlus.select(1, layer + 1));
        image = image.defined() ? output + UpsampleImage(image) : output;
    }
    return image;
}

StyleGenerator::Kernel StyleGenerator::KernelOf(int layer) const {
    const Tensor& raw = At(LayerName(layer) + ".weight");  // row, column, in, out
    const double fanIn = double(raw.size(0) * raw.size(1) * raw.size(2));
    const Tensor kernel = raw.permute({3, 2, 0, 1}).contiguous() / std::sqrt(fanIn);
    const Tensor energy = kernel.square().sum({2, 3});
    return {DoublesResolution(layer) ? SplitKernel(kernel) : kernel, energy};
}

void StyleGenerator::KeepKernels() {
    const torch::NoGradGuard noGradients;
    kept_.clear();
    std::vector<Kernel> kernels;
    for (int layer = 0; layer < config_.NumLayers(); ++layer) kernels.push_back(KernelOf(layer));
    kept_ = std::move(kernels);
}

Tensor StyleGenerator::Style(const std::string& name, const Tensor& w) const {
    const Tensor& weights = At(name + ".style.fc.weight");
    return torch::matmul(w, weights.t()) / std::sqrt(double(weights.size(1))) + At(name + ".style.bias") + 1;
}

Tensor StyleGenerator::Layer(int layer, const Tensor& x, const Tensor& w, const Tensor& noise) const {
    const std::string name = LayerName(layer);
    const Kernel kernel = kept_.empty() ? KernelOf(layer) : kept_[size_t(layer)];
    // Modulated kernels [Karras et al. 2020, eq. 1, 3] as scales of what goes in and of what comes out.
    const Tensor style = Style(name, w);
    const Tensor scaled = x * style.unsqueeze(-1).unsqueeze(-1);
    const Tensor y = DoublesResolution(layer) ? UpsampleAndConvolve(scaled, kernel.weights)
                                              : torch::conv2d(scaled, kernel.weights, {}, 1, 1);
    // The gain of the activation goes into small tensors: it commutes with what is linear on half-lines.
    const Tensor scale =
        kStyleGain * torch::rsqrt(torch::matmul(style.square(), kernel.energy.t()) + kStyleEpsilon);
    const Tensor noiseTerm = noise * (kStyleGain * At(name + ".noise_strength")),
                 bias = kStyleGain * At(name + ".bias");
    return torch::leaky_relu(
        torch::addcmul(noiseTerm, y, scale.unsqueeze(-1).unsqueeze(-1)) + bias.unsqueeze(-1).unsqueeze(-1),
        kStyleSlope);
}

Tensor StyleGenerator::Output(int output, const Tensor& x, const Tensor& w) const {
    const std::string name = OutputName(output);
    const Tensor& raw = At(name + ".weight");
    const Tensor kernel = raw.permute({3, 2, 0, 1}) / std::sqrt(double(raw.size(2)));
    return torch::conv2d(x * Style(name, w).unsqueeze(-1).unsqueeze(-1), kernel, At(name + ".bias"));
}

Tensor StyleGenerator::Repeat(const Tensor& w) const {
    return w.unsqueeze(1).expand({-1, config_.NumColumns(), -1});
}

std::vector<Tensor> StyleGenerator::ZeroNoise(int64_t batch) const {
    std::vector<Tensor> noise;
    for (const int res : config_.NoiseResolutions()) noise.push_back(torch::zeros({batch, 1, res, res}));
    return noise;
}

std::vector<Tensor> StyleGenerator::RandomNoise(int64_t batch, torch::Generator generator) const {
    std::vector<Tensor> noise;
    for (const int res : config_.NoiseResolutions())
        noise.push_back(NormalNumbers({batch, 1, res, res}, generator));
    return noise;
}

TensorMap RandomGeneratorParameters(const GeneratorConfig& config, torch::Generator generator) {
    TensorMap parameters;
    for (const TensorSpec& spec : GeneratorTensors(config)) {
        const std::vector<int64_t> shape(spec.shape.begin(), spec.shape.end());
        Tensor value;
        if (spec.name.ends_with(".noise_strength"))
            value = torch::full(shape, kStartStrength);
        else if (spec.name.ends_with(".bias"))
            value = torch::zeros(shape);
        else
            value = NormalNumbers(shape, generator);
        // Weights of the mapping are multiplied by the rate when they are used.
        if (spec.name.starts_with("mapping.")) value = value / config.lrMultiplier;
        parameters.emplace(spec.name, value);
    }
    return parameters;
}

}  // namespace lacquer::materialgan
