#include "materialgan/network/encoder.h"

#include <fmt/format.h>

#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

constexpr double kEncoderSlope = 0.2, kMinLogVariance = -8, kMaxLogVariance = 4;
constexpr int64_t kCoarsestTexels = 16;

std::string HeadName(int res) { return fmt::format("encoder.noise{}", res); }
std::string DownName(int res) { return fmt::format("encoder.down{}", res); }

int64_t NumNoiseMaps(int res) { return res == 4 ? 1 : 2; }

Tensor Activated(const Tensor& x) { return torch::leaky_relu(x, kEncoderSlope); }

}  // namespace

MapEncoder::MapEncoder(const GeneratorConfig& config, TensorMap parameters)
    : config_(config), parameters_(std::move(parameters)) {
    for (const TensorSpec& spec : EncoderTensors(config)) LACQUER_CHECK(parameters_.contains(spec.name));
}

Tensor MapEncoder::Convolve(const std::string& name, const Tensor& x, int64_t stride) const {
    return torch::conv2d(x, parameters_.at(name + ".weight"), parameters_.at(name + ".bias"), stride, 1);
}

Encoding MapEncoder::Encode(const Tensor& maps) const {
    Encoding e;
    Tensor x = Activated(Convolve("encoder.input", maps, 1));
    // From fine to coarse; the generator counts the other way.
    std::vector<Tensor> means, logVariances;
    for (int res = config_.resolution; res >= 4; res /= 2) {
        const Tensor head = Convolve(HeadName(res), x, 1);
        const int64_t count = NumNoiseMaps(res);
        for (int64_t map = count - 1; map >= 0; --map) {
            means.push_back(head.narrow(1, map, 1));
            // Starts with noise that says something: its deviation is below that of the prior.
            logVariances.push_back(head.narrow(1, count + map, 1).clamp(kMinLogVariance, kMaxLogVariance) -
                                   1);
        }
        if (res > 4) x = Activated(Convolve(DownName(res), x, 2));
    }
    e.noiseMean.assign(means.rbegin(), means.rend());
    e.noiseLogVariance.assign(logVariances.rbegin(), logVariances.rend());
    const Tensor style =
        torch::addmm(parameters_.at("encoder.z.bias"), x.flatten(1), parameters_.at("encoder.z.weight").t());
    e.zMean = style.narrow(1, 0, config_.latentSize);
    e.zLogVariance =
        style.narrow(1, config_.latentSize, config_.latentSize).clamp(kMinLogVariance, kMaxLogVariance);
    return e;
}

std::vector<TensorSpec> EncoderTensors(const GeneratorConfig& config) {
    std::vector<TensorSpec> tensors;
    const auto add = [&](const std::string& name, std::vector<size_t> shape) {
        const size_t out = shape[0];
        tensors.push_back({name + ".weight", std::move(shape)});
        tensors.push_back({name + ".bias", {out}});
    };
    const auto maps = [&](int res) { return size_t(config.NumFeatureMaps(res)); };
    add("encoder.input", {maps(config.resolution), capture::kNumChannels, 3, 3});
    for (int res = config.resolution; res >= 4; res /= 2) {
        add(HeadName(res), {size_t(2 * NumNoiseMaps(res)), maps(res), 3, 3});
        if (res > 4) add(DownName(res), {maps(res / 2), maps(res), 4, 4});
    }
    add("encoder.z", {size_t(2 * config.latentSize), maps(4) * size_t(kCoarsestTexels)});
    return tensors;
}

TensorMap RandomEncoderParameters(const GeneratorConfig& config, torch::Generator generator) {
    TensorMap parameters;
    double bound = 0;
    for (const TensorSpec& spec : EncoderTensors(config)) {
        const std::vector<int64_t> shape(spec.shape.begin(), spec.shape.end());
        // Weights come before the bias of the same layer; both within 1 / sqrt(fan-in).
        if (spec.shape.size() > 1) {
            double fanIn = 1;
            for (size_t i = 1; i < spec.shape.size(); ++i) fanIn *= double(spec.shape[i]);
            bound = 1 / std::sqrt(fanIn);
        }
        parameters.emplace(spec.name, torch::empty(shape).uniform_(-bound, bound, generator));
    }
    return parameters;
}

}  // namespace lacquer::materialgan
