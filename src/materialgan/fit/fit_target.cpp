#include "materialgan/fit/fit_target.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "materialgan/fit/steerable_features.h"

namespace lacquer::materialgan {
namespace {

/// Weights of the features of each level, finest first [Guo et al. 2020b]; as shares of their sum.
constexpr std::array<double, kMaxFeatureLevels> kWeightsForW{1, 1, 4, 8}, kWeightsForNoise{8, 8, 2, 1};

double DecodeSRGB(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

/// Values of photographs to the power 1/2.2, in place.
void ToGamma(capture::Response response, std::vector<float>* values) {
    if (response == capture::Response::Gamma22) return;
    for (float& value : *values) {
        const double v = std::clamp(double(value), 0., 1.);
        value = float(std::pow(response == capture::Response::SRGB ? DecodeSRGB(v) : v, 1 / 2.2));
    }
}

Tensor ConstantMaps(int size, std::array<float, capture::kNumChannels> stored) {
    const Tensor channels = torch::from_blob(stored.data(), {1, int64_t(stored.size()), 1, 1}).clone();
    return channels.expand({-1, -1, size, size}).clone();
}

Tensor TotalVariation(const Tensor& maps) {
    const int64_t n = maps.size(2) - 1;
    return (maps.narrow(2, 1, n) - maps.narrow(2, 0, n)).abs().mean() +
           (maps.narrow(3, 1, n) - maps.narrow(3, 0, n)).abs().mean();
}

}  // namespace

FitTarget TargetOf(const FitInput& input, bool ofTests) {
    const auto& views = input.views.views;
    if (input.images.size() != views.size())
        throw std::invalid_argument(fmt::format("{} images for {} views", input.images.size(), views.size()));
    std::vector<Tensor> images;
    for (size_t i = 0; i < views.size(); ++i) {
        if (views[i].isTest != ofTests) continue;
        std::vector<float> values = input.images[i];
        if (input.size < 1 || values.size() != 3 * size_t(input.size) * size_t(input.size))
            throw std::invalid_argument(
                fmt::format("image {} has {} values, and size {}", i, values.size(), input.size));
        ToGamma(input.views.response, &values);
        images.push_back(torch::from_blob(values.data(), {3, input.size, input.size}).clone());
    }
    if (images.empty() && !ofTests) throw std::invalid_argument("there are no views to fit");
    return {ViewsOf(input.views, ofTests),
            images.empty() ? torch::empty({0, 3, input.size, input.size}) : torch::stack(images)};
}

double FitTarget::Rmse(const Tensor& maps) const {
    if (NumViews() == 0) return 0;
    const torch::NoGradGuard noGradients;
    return std::sqrt((RenderEncoded(maps, views)[0] - images).square().mean().item<double>());
}

PhotoObjective::PhotoObjective(const FitTarget& target, FitFeatures features, double pixelWeight,
                               double featureWeight)
    : target_(target), features_(features), pixelWeight_(pixelWeight), featureWeight_(featureWeight) {
    if (features_ == FitFeatures::Steerable) targetFeatures_ = SteerableFeatures(target.images);
}

PhotoObjective::Value PhotoObjective::Evaluate(const Tensor& maps, FitPhase phase) const {
    const Tensor rendered = RenderEncoded(maps, target_.views)[0];
    const Tensor pixels = (rendered - target_.images).square().mean();
    Value value{pixelWeight_ * pixels, pixels.item<double>()};
    if (features_ == FitFeatures::None) return value;
    const std::vector<Tensor> found = SteerableFeatures(rendered);
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

TexelDescent DescendTexels(const FitTarget& target, const Tensor& start, const TexelFitOptions& options,
                           const char* stage, const FitObserver& observer) {
    TexelDescent descent{start.detach().clamp(-1, 1).clone(), {}};
    Tensor texels = descent.maps.clone();
    Adam adam({texels});
    for (int i = 0; i < options.iterations; ++i) {
        const Tensor maps = texels.clamp(-1, 1);
        const Tensor pixels = (RenderEncoded(maps, target.views)[0] - target.images).square().mean();
        const Tensor loss =
            options.totalVariation > 0 ? pixels + options.totalVariation * TotalVariation(maps) : pixels;
        const double value = loss.item<double>();
        if (!std::isfinite(value)) {
            descent.isFinite = false;
            return descent;
        }
        descent.maps = maps.detach();
        descent.losses.push_back(value);
        const FitProgress progress{stage, i, options.iterations, value, std::sqrt(pixels.item<double>())};
        if (observer && !observer(progress)) {
            descent.isStopped = true;
            return descent;
        }
        loss.backward();
        adam.Step(options.rate);
    }
    const Tensor last = texels.detach().clamp(-1, 1);
    if (last.isfinite().all().item<bool>()) descent.maps = last;
    return descent;
}

Tensor GreyMaps(int size) {
    // As stored from 0 to 1: albedo 0.5, roughness 0.4, specular albedo 0.2.
    return ConstantMaps(size, {0, 0, 0, 0, 0, -0.2f, -0.6f, -0.6f, -0.6f});
}

Tensor SmoothMetalMaps(int size) {
    return ConstantMaps(size, {-0.6f, -0.6f, -0.6f, 0, 0, -0.4f, 0.4f, 0.4f, 0.4f});
}

}  // namespace lacquer::materialgan
