// Summaries by the network VGG-19, for users who have its weights.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "estimate/summary/summary.h"
#include "pbrt/image/vgg_weights.h"

namespace lacquer::estimate {

/// The convolutions of the network, 3 x 3 each, in blocks of two, two, four, four and four.
struct VggWeights {
    struct Layer {
        Eigen::MatrixXd
            weights;  ///< a row for each output; columns by row, column of the filter, input channel
        Eigen::VectorXd bias;
    };
    std::vector<Layer> layers;  ///< all sixteen

    /// Errors: those of ReadVggLayers().
    static std::shared_ptr<const VggWeights> Read(const std::string& path,
                                                  const std::array<size_t, 5>& channels = kVggChannels);
};

/// "vgg": Gram matrices before each of the five poolings [Gatys et al. 2015], of which 40 random projections
/// of rank one are taken each: 200 numbers instead of 610,304. Poolings are means. At 256^2 a run takes about
/// a second; for a mode, not for chains.
std::unique_ptr<Summary> MakeVggSummary(const MapGrid& grid, std::shared_ptr<const VggWeights> weights);

}  // namespace lacquer::estimate
