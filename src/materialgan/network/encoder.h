// From maps to distributions of latents: what a ladder of convolutions makes of them.
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

/// Independent normal distributions of z and of each number of the noise maps.
struct Encoding {
    Tensor zMean, zLogVariance;                       ///< B x latentSize
    std::vector<Tensor> noiseMean, noiseLogVariance;  ///< B x 1 x res x res, as the generator takes them
};

class MapEncoder {
  public:
    /// @param parameters  all of EncoderTensors(config)
    MapEncoder(const GeneratorConfig& config, TensorMap parameters);
    const TensorMap& Parameters() const { return parameters_; }

    /// @param maps  B x 9 x resolution x resolution
    Encoding Encode(const Tensor& maps) const;

  private:
    Tensor Convolve(const std::string& name, const Tensor& x, int64_t stride) const;

    GeneratorConfig config_;
    TensorMap parameters_;
};

/// A convolution at full resolution, one of stride 2 to each coarser one with the generator's numbers of
/// feature maps, at each resolution one for its noise, and a dense layer for z.
std::vector<TensorSpec> EncoderTensors(const GeneratorConfig& config);
TensorMap RandomEncoderParameters(const GeneratorConfig& config, torch::Generator generator);

}  // namespace lacquer::materialgan
