// Tensors of libtorch by name, and between them and files. Only .cpp files of this module include it.
#pragma once

#include <torch/torch.h>

#include <map>
#include <span>
#include <string>

#include "capture/maps.h"
#include "materialgan/generator_config.h"
#include "pbrt/image/safetensors.h"

namespace lacquer::materialgan {

using torch::Tensor;
using TensorMap = std::map<std::string, Tensor>;

/// Errors: FileError, those of SafetensorsFile::Read().
Tensor ReadTensor(const SafetensorsFile& file, const std::string& name, std::span<const size_t> shape);
/// All of `tensors`. Errors: as above.
TensorMap ReadTensors(const SafetensorsFile& file, std::span<const TensorSpec> tensors);

NamedTensor ToNamedTensor(const std::string& name, const Tensor& tensor);
/// In the order of their names.
void AppendTensors(const TensorMap& tensors, const std::string& prefix, std::vector<NamedTensor>* out);

/// 9 x size x size, float.
Tensor ToTensor(const capture::Maps& maps);
/// Of such a tensor, or of one with a leading dimension of 1.
capture::Maps ToMaps(const Tensor& tensor);

/// Standard normal numbers, for the same seed the same ones.
Tensor NormalNumbers(torch::IntArrayRef shape, torch::Generator generator);
torch::Generator SeededGenerator(uint64_t seed);

/// Threads of libtorch, and algorithms whose bits repeat. For the whole process.
void ConfigureTorch(int threads);

}  // namespace lacquer::materialgan
