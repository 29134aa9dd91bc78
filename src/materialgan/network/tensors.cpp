#include "materialgan/network/tensors.h"

#include <ATen/CPUGeneratorImpl.h>

#include "pbrt/core/check.h"

namespace lacquer::materialgan {

Tensor ReadTensor(const SafetensorsFile& file, const std::string& name, std::span<const size_t> shape) {
    std::vector<float> values = file.Read(name, shape);
    std::vector<int64_t> sizes(shape.begin(), shape.end());
    return torch::from_blob(values.data(), sizes, torch::kFloat).clone();
}

TensorMap ReadTensors(const SafetensorsFile& file, std::span<const TensorSpec> tensors) {
    TensorMap map;
    for (const TensorSpec& spec : tensors) map.emplace(spec.name, ReadTensor(file, spec.name, spec.shape));
    return map;
}

NamedTensor ToNamedTensor(const std::string& name, const Tensor& tensor) {
    const Tensor plain = tensor.detach().to(torch::kFloat).contiguous();
    NamedTensor named{name, {}, {}};
    for (const int64_t n : plain.sizes()) named.shape.push_back(size_t(n));
    const float* data = plain.data_ptr<float>();
    named.values.assign(data, data + plain.numel());
    return named;
}

void AppendTensors(const TensorMap& tensors, const std::string& prefix, std::vector<NamedTensor>* out) {
    for (const auto& [name, tensor] : tensors) out->push_back(ToNamedTensor(prefix + name, tensor));
}

Tensor ToTensor(const capture::Maps& maps) {
    const int64_t channels = int64_t(capture::kNumChannels);
    Tensor tensor = torch::empty({channels, maps.size, maps.size}, torch::kFloat);
    std::ranges::transform(maps.values, tensor.data_ptr<float>(), [](double v) { return float(v); });
    return tensor;
}

capture::Maps ToMaps(const Tensor& tensor) {
    const Tensor plain = tensor.detach().to(torch::kFloat).contiguous();
    const int64_t size = plain.size(-1);
    LACQUER_CHECK(plain.numel() == int64_t(capture::kNumChannels) * size * size);
    capture::Maps maps{int(size)};
    const float* data = plain.data_ptr<float>();
    std::copy(data, data + plain.numel(), maps.values.begin());
    return maps;
}

Tensor NormalNumbers(torch::IntArrayRef shape, torch::Generator generator) {
    return torch::randn(shape, std::move(generator), torch::TensorOptions(torch::kFloat));
}

torch::Generator SeededGenerator(uint64_t seed) { return at::detail::createCPUGenerator(seed); }

void ConfigureTorch(int threads) {
    at::set_num_threads(threads);
    at::globalContext().setDeterministicAlgorithms(true, /*warn_only=*/false);
}

}  // namespace lacquer::materialgan
