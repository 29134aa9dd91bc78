// What a fit compares with: photographs as tensors, and how far renderings are from them.
#pragma once

#include "materialgan/latent_fit.h"
#include "materialgan/network/adam.h"
#include "materialgan/network/torch_render.h"

namespace lacquer::materialgan {

struct FitTarget {
    TorchViews views;
    Tensor images;  ///< V x 3 x R x R, to the power 1/2.2

    int64_t NumViews() const { return images.size(0); }
    /// Root of the mean squared difference of the rendered maps, 1 x 9 x R x R. Without gradients.
    double Rmse(const Tensor& maps) const;
};
/// The views to fit, or those held out. Errors: std::invalid_argument as in latent_fit.h.
FitTarget TargetOf(const FitInput& input, bool ofTests);

/// Which latents a step moves: features count differently for each.
enum class FitPhase { W, Noise };

/// Levels of features of images (V x 3 x R x R, to the power 1/2.2), at most kMaxFeatureLevels, fine ones
/// first: V x c x r x r each. Empty: none.
using PhotoFeatures = std::function<std::vector<Tensor>(const Tensor& images)>;
/// @param weightsFile  for FitFeatures::Vgg. Errors: FileError, those of ReadVggLayers().
PhotoFeatures MakePhotoFeatures(FitFeatures kind, const std::string& weightsFile);

/// The loss of [Guo et al. 2020b], eq. 3: squared differences of pixels and of features.
class PhotoObjective {
  public:
    PhotoObjective(const FitTarget& target, PhotoFeatures features, double pixelWeight, double featureWeight);
    struct Value {
        Tensor loss;
        double pixelLoss = 0;
    };
    /// @param maps  1 x 9 x R x R
    Value Evaluate(const Tensor& maps, FitPhase phase) const;

  private:
    const FitTarget& target_;
    PhotoFeatures features_;
    double pixelWeight_, featureWeight_;
    std::vector<Tensor> targetFeatures_;
};

/// A smooth metal.
Tensor SmoothMetalMaps(int size);

}  // namespace lacquer::materialgan
