#include "pbrt/image/vgg_weights.h"

#include <fmt/format.h>

#include "pbrt/image/safetensors.h"

namespace lacquer {

std::vector<VggLayer> ReadVggLayers(const std::string& path, size_t numLayers,
                                    const std::array<size_t, 5>& channels) {
    const SafetensorsFile file(path);
    std::vector<VggLayer> layers;
    size_t in = 3;
    int index = 0;  // of torchvision: convolutions and rectifiers in turn, and a pooling after each block
    for (size_t block = 0; block < channels.size(); ++block, ++index)
        for (int i = 0; i < kVggLayersOfBlock[block] && layers.size() < numLayers; ++i, index += 2) {
            const size_t out = channels[block];
            const size_t shape[] = {out, in, 3, 3}, biasShape[] = {out};
            layers.push_back({in, out, file.Read(fmt::format("features.{}.weight", index), shape),
                              file.Read(fmt::format("features.{}.bias", index), biasShape)});
            in = out;
        }
    return layers;
}

}  // namespace lacquer
