// Features of images by the network VGG-19, for users who have its weights.
#pragma once

#include "materialgan/network/tensors.h"
#include "pbrt/image/vgg_weights.h"

namespace lacquer::materialgan {

/// What the rectifiers behind conv1_1, conv1_2, conv3_2 and conv4_2 give [Guo et al. 2020b], with means in
/// place of the maxima of the poolings [Gatys et al. 2015].
class VggFeatures {
  public:
    /// @param channels  of the file's blocks. Errors: FileError, those of ReadVggLayers().
    explicit VggFeatures(const std::string& path, const std::array<size_t, 5>& channels = kVggChannels);

    /// @param images  V x 3 x R x R with R from 8 on, from 0 to 1
    /// @return        for the four layers V x channels x r x r with r of R, R, R/4 and R/8
    std::vector<Tensor> operator()(const Tensor& images) const;

  private:
    struct Convolution {
        Tensor weights, bias;  ///< out x in x 3 x 3, out
    };
    std::vector<Convolution> convolutions_;  ///< up to the last that counts
    Tensor means_, deviations_;              ///< 1 x 3 x 1 x 1
};

}  // namespace lacquer::materialgan
