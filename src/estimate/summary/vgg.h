// Summaries by the network VGG-19, for users who have its weights.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "estimate/summary/summary.h"

namespace lacquer::estimate {

/// The convolutions of the network, 3 x 3 each, in blocks of two, two, four, four and four.
struct VggWeights {
    /// Channels of the blocks: those of the network. Tests have fewer.
    static constexpr std::array<size_t, 5> kChannels{64, 128, 256, 512, 512};
    static constexpr std::array<int, 5> kLayersOfBlock{2, 2, 4, 4, 4};
    struct Layer {
        Eigen::MatrixXd
            weights;  ///< a row for each output; columns by row, column of the filter, input channel
        Eigen::VectorXd bias;
    };
    std::vector<Layer> layers;  ///< all sixteen

    /// From a safetensors file with the names that torchvision has: features.0.weight, features.0.bias, ...,
    /// features.34. Errors: FileError that names a tensor that is not there, or not as it should be.
    static std::shared_ptr<const VggWeights> Read(const std::string& path,
                                                  const std::array<size_t, 5>& channels = kChannels);
};

/// "vgg": Gram matrices before each of the five poolings [Gatys et al. 2015], of which 40 random projections
/// of rank one are taken each: 200 numbers instead of 610,304. Poolings are means. At 256^2 a run takes about
/// a second; for a mode, not for chains.
std::unique_ptr<Summary> MakeVggSummary(const MapGrid& grid, std::shared_ptr<const VggWeights> weights);

}  // namespace lacquer::estimate
