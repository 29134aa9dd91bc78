#include "materialgan/fit/vgg_features.h"

namespace lacquer::materialgan {
namespace {

/// conv1_1, conv1_2, conv3_2 and conv4_2, counted from 0 over all convolutions.
constexpr std::array<size_t, 4> kTaps{0, 1, 5, 9};
constexpr size_t kNumConvolutions = kTaps.back() + 1;

Tensor ShapedTensor(std::vector<float> values, torch::IntArrayRef shape) {
    return torch::from_blob(values.data(), shape, torch::kFloat).clone();
}

Tensor PerChannel(const std::array<double, 3>& values) {
    return torch::tensor(torch::ArrayRef<double>(values.data(), values.size()), torch::kFloat)
        .view({1, 3, 1, 1});
}

}  // namespace

VggFeatures::VggFeatures(const std::string& path, const std::array<size_t, 5>& channels)
    : means_(PerChannel(kVggMeans)), deviations_(PerChannel(kVggDeviations)) {
    for (VggLayer& layer : ReadVggLayers(path, kNumConvolutions, channels)) {
        const auto in = int64_t(layer.in), out = int64_t(layer.out);
        convolutions_.push_back({ShapedTensor(std::move(layer.weights), {out, in, 3, 3}),
                                 ShapedTensor(std::move(layer.bias), {out})});
    }
}

std::vector<Tensor> VggFeatures::operator()(const Tensor& images) const {
    std::vector<Tensor> features;
    Tensor x = (images - means_) / deviations_;
    size_t layer = 0;
    for (const int numLayers : kVggLayersOfBlock) {
        for (int i = 0; i < numLayers; ++i, ++layer) {
            x = torch::relu(torch::conv2d(x, convolutions_[layer].weights, convolutions_[layer].bias, 1, 1));
            if (layer == kTaps[features.size()]) features.push_back(x);
            if (features.size() == kTaps.size()) return features;
        }
        x = torch::avg_pool2d(x, 2);
    }
    return features;
}

}  // namespace lacquer::materialgan
