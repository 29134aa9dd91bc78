// A material's maps from photographs, as what a generator can make [Guo et al. 2020b], and without one.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/svbrdf/pixel_fit.h"
#include "materialgan/material_prior.h"

namespace lacquer::materialgan {

/// Photographs of a sample. Those that the views call tests are looked at for their error only.
struct FitInput {
    capture::ViewSet views;
    std::vector<capture::RectifiedImage> images;  ///< one for each view, of the generator's size
};

enum class FitOptimizer { Adam, Sign };
/// What the features are that photographs are compared by, besides their pixels.
enum class FitFeatures {
    None,
    Steerable,  ///< that need no training
    Vgg  ///< of the network VGG-19, as in the paper; its weights are a file (LatentFitOptions::featuresFile)
};
enum class FitStart {
    Two,   ///< the mean material and a smooth metal for 80 iterations each; the better one from its beginning
    Full,  ///< both to the end
    Encoder  ///< what the encoder makes of a fit of texels
};

/// A fit of texels by themselves, from a constant and at one size: what the encoder starts from. Where the
/// sample varies from texel to texel it explains the photographs better than one from coarse to fine, and
/// the generator brings what that would have.
capture::FitSettings TexelFitSettings();
/// Of texels by themselves after a fit of latents: what photographs say beyond what the generator can make.
capture::FitSettings RefinementSettings();

struct LatentFitOptions {
    /// After each iteration of the fit, from the calling thread; may be empty.
    std::function<void(const capture::FitStep&)> afterStep;
    capture::FitCheckpoint* checkpoint = nullptr;  ///< as capture::FitSettings has it, for all parts
    int testEvery = 0;  ///< iterations from one look at the photographs for tests to the next; 0: none
    int iterations = 240;
    /// 1: w+, then noise; 2: both at once; 3: ten of each in turn, as the paper has it, which leaves a larger
    /// error with generators of ours (docs/capture-figures.md).
    int strategy = 2;
    FitOptimizer optimizer = FitOptimizer::Adam;
    FitFeatures features = FitFeatures::None;
    std::string featuresFile;       ///< for Vgg: safetensors with the names that torchvision has
    std::optional<FitStart> start;  ///< none: the encoder where there is one, else Two
    double rateW = 0.03, rateNoise = 0.06;
    double pixelWeight = 1, featureWeight = 0.1;
    double priorWeight = 0.001;  ///< of the distributions of w and noise; 0 as in the paper
    capture::FitSettings refinement = RefinementSettings();
};

/// What a command line says of features: "none", "steerable", or a file with the weights of VGG-19.
void SetFeatures(const std::string& text, LatentFitOptions* options);

struct FitResult {
    capture::Maps maps;  ///< refined
    capture::Maps beforeRefinement;
    capture::Maps texels;  ///< the fit that the encoder started from; of size 0 if there was none
    Latents latents;       ///< none of a fit of texels
    /// Mean squares of w, from its mean and in its deviations, and of the noise: 1 as trained.
    double styleEnergy = 0, noiseEnergy = 0;
    double unrefinedRmse = 0;    ///< of the photographs that were fitted, before the refinement
    double inputRmse = 0;        ///< of values of photographs to the power 1/2.2
    double testRmse = 0;         ///< 0 without test views
    std::vector<double> losses;  ///< of the iterations
    capture::FitResult::End end = capture::FitResult::End::Finished;  ///< NotFinite: the last good state
};

/// @param texels  what the encoder starts from; null: a fit by TexelFitSettings(), made here
/// The light's power is that of the views.
/// Errors: std::invalid_argument for an input without views to fit, with images of another number or size;
/// FileError if the generator makes numbers that are not finite, and for a wrong file of features.
FitResult FitLatents(const MaterialPrior& prior, const FitInput& input, const LatentFitOptions& options,
                     Observer* observer = nullptr, const capture::Maps* texels = nullptr);

/// The weight that did best with generators of ours: the fewer photographs, the more the prior counts.
double DefaultPriorWeight(int numPhotographs);

/// Why the maps are not to be trusted, as a sentence without its full stop; empty if they are. The generator
/// does not know what the photographs show if texels by themselves explain them many times as well; and one
/// photograph leaves too much to it. (docs/capture-figures.md has what the rule gains.)
/// @param texelRmse  what a fit of texels leaves of the photographs
std::string DoubtOf(const FitResult& fit, double texelRmse, int numPhotographs);

/// Where an embedding may go.
enum class LatentSpace { W, WPlus, WPlusNoise, Noise };
/// Latents whose maps are nearest to those given, starting at the mean material.
struct Projection {
    Latents latents;
    capture::Maps maps;
    double rmse = 0;  ///< of stored values, as parts of their range
};
Projection ProjectMaps(const MaterialPrior& prior, const capture::Maps& maps, LatentSpace space,
                       int iterations, Observer* observer = nullptr);

}  // namespace lacquer::materialgan
