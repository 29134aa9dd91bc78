// The generator: StyleGAN2, configuration F with skip connections [Karras et al. 2020], as in MaterialGAN
// [Guo et al. 2020b], as functions of tensors.
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

class StyleGenerator {
  public:
    /// @param parameters  all of GeneratorTensors(config)
    StyleGenerator(const GeneratorConfig& config, TensorMap parameters);

    const GeneratorConfig& Config() const { return config_; }
    const TensorMap& Parameters() const { return parameters_; }

    /// w of z: B x latentSize both.
    Tensor Map(const Tensor& z) const;
    /// Nine channels of maps, B x 9 x resolution x resolution, not clamped.
    /// @param wPlus  B x NumColumns() x latentSize
    /// @param noise  a map for each layer, (1 or B) x 1 x res x res with the res of NoiseResolutions()
    Tensor Synthesize(const Tensor& wPlus, const std::vector<Tensor>& noise) const;

    /// Prepares the kernels once, for parameters that stay as they are.
    void KeepKernels();

    /// A column of w (B x latentSize) for all columns of w+.
    Tensor Repeat(const Tensor& w) const;
    /// Noise of zeros or of normal numbers. @param batch  maps of each
    std::vector<Tensor> ZeroNoise(int64_t batch) const;
    std::vector<Tensor> RandomNoise(int64_t batch, torch::Generator generator) const;

  private:
    /// A kernel with equalised learning rate, ready for conv2d, and what demodulation needs of it.
    struct Kernel {
        Tensor weights, energy;  ///< of `energy`: out x in, the sum of squares
    };
    const Tensor& At(const std::string& name) const { return parameters_.at(name); }
    Kernel KernelOf(int layer) const;
    Tensor Style(const std::string& name, const Tensor& w) const;
    Tensor Layer(int layer, const Tensor& x, const Tensor& w, const Tensor& noise) const;
    Tensor Output(int output, const Tensor& x, const Tensor& w) const;

    GeneratorConfig config_;
    TensorMap parameters_;
    std::vector<Kernel> kept_;
};

/// Parameters to start a training with: normal weights, zero biases, noise of strength 0.3.
TensorMap RandomGeneratorParameters(const GeneratorConfig& config, torch::Generator generator);

}  // namespace lacquer::materialgan
