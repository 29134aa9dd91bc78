// The opponent of the generator: the residual discriminator of StyleGAN2 [Karras et al. 2020].
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

class Discriminator {
  public:
    /// @param parameters  all of DiscriminatorTensors(config); of single or of double precision
    Discriminator(const GeneratorConfig& config, TensorMap parameters);
    const TensorMap& Parameters() const { return parameters_; }

    /// A number for each image: the larger, the more it looks like one of the training's. Images of a batch
    /// count for each other by their deviation.
    /// @param maps  B x 9 x resolution x resolution
    /// @return      B
    Tensor Judge(const Tensor& maps) const;

  private:
    Tensor Convolve(const std::string& name, const Tensor& x, int64_t stride, int64_t padding) const;
    Tensor Block(int res, const Tensor& x) const;
    Tensor Dense(const std::string& name, const Tensor& x) const;

    GeneratorConfig config_;
    TensorMap parameters_;
};

/// Numbers of feature maps are the generator's, from fine to coarse; a block halves the resolution.
std::vector<TensorSpec> DiscriminatorTensors(const GeneratorConfig& config);
/// Normal weights, which are scaled when they are used, and biases of 0.
TensorMap RandomDiscriminatorParameters(const GeneratorConfig& config, torch::Generator generator);

/// Each image with one map more, that has everywhere the mean deviation over the images of a group of up to
/// four [Karras et al. 2018, sec. 3]. A batch falls into groups of equal size.
/// @param x  B x C x H x W
Tensor AppendMinibatchDeviation(const Tensor& x);

}  // namespace lacquer::materialgan
