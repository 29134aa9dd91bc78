// The convolutions of the network VGG-19 [Simonyan and Zisserman 2015] from a file of tensors.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace lacquer {

/// Channels of its five blocks, and how many convolutions of 3 x 3 each block has. Tests have fewer channels.
inline constexpr std::array<size_t, 5> kVggChannels{64, 128, 256, 512, 512};
inline constexpr std::array<int, 5> kVggLayersOfBlock{2, 2, 4, 4, 4};
/// What red, green and blue from 0 to 1 were normalised by when it was trained.
inline constexpr std::array<double, 3> kVggMeans{0.485, 0.456, 0.406}, kVggDeviations{0.229, 0.224, 0.225};

struct VggLayer {
    size_t in = 0, out = 0;      ///< channels
    std::vector<float> weights;  ///< out x in x 3 x 3, the last index fastest
    std::vector<float> bias;     ///< out
};

/// The first `numLayers` of all sixteen. The file names its tensors as torchvision does: features.0.weight,
/// features.0.bias, ..., features.34.
/// Errors: FileError that names a tensor that is not there, or not as it should be.
std::vector<VggLayer> ReadVggLayers(const std::string& path, size_t numLayers,
                                    const std::array<size_t, 5>& channels = kVggChannels);

}  // namespace lacquer
