#include "materialgan/training/discriminator.h"

#include <fmt/format.h>

#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

constexpr double kJudgeSlope = 0.2, kDeviationEpsilon = 1e-8;
const double kJudgeGain = std::sqrt(2.0);
constexpr int64_t kMaxGroup = 4, kCoarsestSize = 4;

Tensor Activated(const Tensor& x) { return torch::leaky_relu(x, kJudgeSlope) * kJudgeGain; }

/// [1,3,3,1] / 8 along one dimension: three numbers fewer.
Tensor BlurAlong(const Tensor& x, int64_t dimension) {
    const int64_t n = x.size(dimension) - 3;
    const Tensor outer = x.narrow(dimension, 0, n) + x.narrow(dimension, 3, n),
                 inner = x.narrow(dimension, 1, n) + x.narrow(dimension, 2, n);
    return (outer + 3 * inner) / 8;
}

/// The filter of StyleGAN2, with zeros around.
Tensor Blur(const Tensor& x, int64_t padding) {
    return BlurAlong(BlurAlong(torch::constant_pad_nd(x, {padding, padding, padding, padding}), 2), 3);
}

std::string BlockName(int res) { return fmt::format("discriminator.block{}", res); }

}  // namespace

Discriminator::Discriminator(const GeneratorConfig& config, TensorMap parameters)
    : config_(config), parameters_(std::move(parameters)) {
    for (const TensorSpec& spec : DiscriminatorTensors(config))
        LACQUER_CHECK(parameters_.contains(spec.name));
}

Tensor Discriminator::Judge(const Tensor& maps) const {
    Tensor x = Activated(Convolve("discriminator.input", maps, 1, 0));
    for (int res = config_.resolution; res > kCoarsestSize; res /= 2) x = Block(res, x);
    x = Activated(Convolve("discriminator.last", AppendMinibatchDeviation(x), 1, 1));
    x = Activated(Dense("discriminator.dense", x.flatten(1)));
    return Dense("discriminator.output", x).flatten();
}

/// [Karras et al. 2020], fig. 7 c: two convolutions beside one of a single texel; the sum has the variance of
/// each.
Tensor Discriminator::Block(int res, const Tensor& x) const {
    const std::string name = BlockName(res);
    const Tensor fine = Activated(Convolve(name + ".conv0", x, 1, 1));
    const Tensor coarse = Activated(Convolve(name + ".conv1", Blur(fine, 2), 2, 0));
    const Tensor skipped = Convolve(name + ".skip", Blur(x, 1), 2, 0);
    return (coarse + skipped) / std::sqrt(2.0);
}

Tensor Discriminator::Convolve(const std::string& name, const Tensor& x, int64_t stride,
                               int64_t padding) const {
    const Tensor& raw = parameters_.at(name + ".weight");
    const auto bias = parameters_.find(name + ".bias");
    const double fanIn = double(raw.size(1) * raw.size(2) * raw.size(3));
    return torch::conv2d(x, raw / std::sqrt(fanIn), bias == parameters_.end() ? Tensor() : bias->second,
                         stride, padding);
}

Tensor Discriminator::Dense(const std::string& name, const Tensor& x) const {
    const Tensor& raw = parameters_.at(name + ".weight");
    return torch::matmul(x, raw.t() / std::sqrt(double(raw.size(1)))) + parameters_.at(name + ".bias");
}

std::vector<TensorSpec> DiscriminatorTensors(const GeneratorConfig& config) {
    std::vector<TensorSpec> tensors;
    const auto add = [&](const std::string& name, std::vector<size_t> shape) {
        const size_t out = shape[0];
        tensors.push_back({name + ".weight", std::move(shape)});
        tensors.push_back({name + ".bias", {out}});
    };
    const auto maps = [&](int res) { return size_t(config.NumFeatureMaps(res)); };
    add("discriminator.input", {maps(config.resolution), capture::kNumChannels, 1, 1});
    for (int res = config.resolution; res > kCoarsestSize; res /= 2) {
        add(BlockName(res) + ".conv0", {maps(res), maps(res), 3, 3});
        add(BlockName(res) + ".conv1", {maps(res / 2), maps(res), 3, 3});
        tensors.push_back({BlockName(res) + ".skip.weight", {maps(res / 2), maps(res), 1, 1}});
    }
    const size_t last = maps(int(kCoarsestSize));
    add("discriminator.last", {last, last + 1, 3, 3});
    add("discriminator.dense", {last, last * size_t(kCoarsestSize * kCoarsestSize)});
    add("discriminator.output", {1, last});
    return tensors;
}

TensorMap RandomDiscriminatorParameters(const GeneratorConfig& config, torch::Generator generator) {
    TensorMap parameters;
    for (const TensorSpec& spec : DiscriminatorTensors(config)) {
        const std::vector<int64_t> shape(spec.shape.begin(), spec.shape.end());
        parameters.emplace(
            spec.name, spec.name.ends_with(".bias") ? torch::zeros(shape) : NormalNumbers(shape, generator));
    }
    return parameters;
}

Tensor AppendMinibatchDeviation(const Tensor& x) {
    const int64_t batch = x.size(0), height = x.size(2), width = x.size(3);
    int64_t group = std::min(kMaxGroup, batch);
    while (batch % group != 0) --group;
    // Images of a group are as far apart as there are groups.
    const Tensor grouped = x.view({group, batch / group, x.size(1), height, width});
    const Tensor variance = (grouped - grouped.mean(0, /*keepdim=*/true)).square().mean(0);
    const Tensor deviation = (variance + kDeviationEpsilon).sqrt().mean({1, 2, 3});
    return torch::cat({x, deviation.repeat({group}).view({batch, 1, 1, 1}).expand({-1, 1, height, width})},
                      1);
}

}  // namespace lacquer::materialgan
