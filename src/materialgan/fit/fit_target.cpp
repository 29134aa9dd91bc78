#include "materialgan/fit/fit_target.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "materialgan/fit/steerable_features.h"
#include "materialgan/fit/vgg_features.h"

namespace lacquer::materialgan {
namespace {

/// Weights of the features of each level, finest first [Guo et al. 2020b]; as shares of their sum.
constexpr std::array<double, kMaxFeatureLevels> kWeightsForW{1, 1, 4, 8}, kWeightsForNoise{8, 8, 2, 1};

Tensor ConstantMaps(int size, std::array<float, capture::kNumChannels> stored) {
    const Tensor channels = torch::from_blob(stored.data(), {1, int64_t(stored.size()), 1, 1}).clone();
    return channels.expand({-1, -1, size, size}).clone();
}

}  // namespace

FitTarget TargetOf(const FitInput& input, bool ofTests) {
    const auto& views = input.views.views;
    const int size = input.images.empty() ? 0 : input.images[0].size;
    capture::CheckFit(input.views, input.images, size);
    std::vector<Tensor> images;
    for (size_t i = 0; i < views.size(); ++i)
        if (views[i].isTest == ofTests)
            images.push_back(torch::from_blob(const_cast<double*>(input.images[i].values.data()),
                                              {3, size, size}, torch::kDouble)
                                 .to(torch::kFloat));
    return {ViewsOf(input.views, ofTests),
            images.empty() ? torch::empty({0, 3, size, size}) : torch::stack(images)};
}

double FitTarget::Rmse(const Tensor& maps) const {
    if (NumViews() == 0) return 0;
    const torch::NoGradGuard noGradients;
    return std::sqrt((RenderEncoded(maps, views)[0] - images).square().mean().item<double>());
}

PhotoFeatures MakePhotoFeatures(FitFeatures kind, const std::string& weightsFile) {
    if (kind == FitFeatures::Steerable) return SteerableFeatures;
    if (kind == FitFeatures::Vgg) return VggFeatures(weightsFile);
    return {};
}

PhotoObjective::PhotoObjective(const FitTarget& target, PhotoFeatures features, double pixelWeight,
                               double featureWeight)
    : target_(target),
      features_(std::move(features)),
      pixelWeight_(pixelWeight),
      featureWeight_(featureWeight) {
    const torch::NoGradGuard noGradients;
    if (features_) targetFeatures_ = features_(target.images);
}

PhotoObjective::Value PhotoObjective::Evaluate(const Tensor& maps, FitPhase phase) const {
    const Tensor rendered = RenderEncoded(maps, target_.views)[0];
    const Tensor pixels = (rendered - target_.images).square().mean();
    Value value{pixelWeight_ * pixels, pixels.item<double>()};
    if (!features_) return value;
    const std::vector<Tensor> found = features_(rendered);
    const auto& weights = phase == FitPhase::W ? kWeightsForW : kWeightsForNoise;
    double sum = 0;
    for (size_t i = 0; i < found.size(); ++i) sum += weights[i];
    Tensor squares = torch::zeros({});
    int64_t count = 0;
    for (size_t i = 0; i < found.size(); ++i) {
        const double weight = weights[i] / sum;
        squares = squares + weight * weight * (found[i] - targetFeatures_[i]).square().sum();
        count += found[i].numel();
    }
    value.loss = value.loss + featureWeight_ * squares / double(count);
    return value;
}

Tensor SmoothMetalMaps(int size) {
    return ConstantMaps(size, {-0.6f, -0.6f, -0.6f, 0, 0, -0.4f, 0.4f, 0.4f, 0.4f});
}

}  // namespace lacquer::materialgan
