// A material's maps from photographs, as what a generator can make [Guo et al. 2020b], and without one.
#pragma once

#include <functional>
#include <optional>

#include "capture/views.h"
#include "materialgan/material_prior.h"

namespace lacquer::materialgan {

/// Photographs of a sample. Those that the views call tests are looked at for their error only.
struct FitInput {
    capture::ViewSet views;
    /// For each view 3 x size x size: red first, rows from the top, values of the file in [0,1] as
    /// `views.response` has them.
    std::vector<std::vector<float>> images;
    int size = 0;  ///< texels along an edge; that of the generator
};

enum class FitOptimizer { Adam, Sign };
/// What the features are that photographs are compared by, besides their pixels.
enum class FitFeatures { None, Steerable };
enum class FitStart {
    Two,   ///< the mean material and a smooth metal for 80 iterations each; the better one from its beginning
    Full,  ///< both to the end
    Encoder  ///< what the encoder makes of a fit of texels
};

struct LatentFitOptions {
    int iterations = 200;
    int strategy = 3;  ///< 1: w+, then noise; 2: both at once; 3: ten of each in turn
    FitOptimizer optimizer = FitOptimizer::Adam;
    FitFeatures features = FitFeatures::None;
    std::optional<FitStart> start;  ///< none: the encoder where there is one, else Two
    double rateW = 0.03, rateNoise = 0.06;
    double pixelWeight = 1, featureWeight = 0.1;
    double priorWeight = 0.001;  ///< of the distributions of w and noise; 0 as in the paper
    int refineIterations = 20;   ///< of the texels by themselves, after the fit
};

struct TexelFitOptions {
    int iterations = 250;
    double rate = 0.02;
    double totalVariation = 0;  ///< weight of the mean difference of neighbours
};

struct FitProgress {
    const char* stage = "";
    int iteration = 0, numIterations = 0;
    double loss = 0;
    double inputRmse = 0;  ///< of values of photographs to the power 1/2.2
};
/// @return  false to stop; the result is then what there is
using FitObserver = std::function<bool(const FitProgress&)>;

struct FitResult {
    capture::Maps maps;  ///< refined
    capture::Maps beforeRefinement;
    Latents latents;  ///< none of a fit of texels
    double inputRmse = 0;
    double testRmse = 0;         ///< 0 without test views
    std::vector<double> losses;  ///< of the iterations
    bool isFinite = true;        ///< false: stopped at a loss that is not finite, at the last good state
    bool isStopped = false;
};

/// Errors: std::invalid_argument for an input without views to fit, with images of another number or size.
FitResult FitLatents(const MaterialPrior& prior, const FitInput& input, const LatentFitOptions& options,
                     const FitObserver& observer = {});

/// Each texel by itself, from `start` or else from a grey dielectric.
FitResult FitTexels(const FitInput& input, const TexelFitOptions& options,
                    const capture::Maps* start = nullptr, const FitObserver& observer = {});

/// Photographs of maps as the model sees them, with the response of the views; 3 x size x size each.
std::vector<std::vector<float>> RenderViews(const capture::Maps& maps, const capture::ViewSet& views);

/// Where an embedding may go.
enum class LatentSpace { W, WPlus, WPlusNoise, Noise };
/// Latents whose maps are nearest to those given, starting at the mean material.
struct Projection {
    Latents latents;
    capture::Maps maps;
    double rmse = 0;  ///< of stored values, as parts of their range
};
Projection ProjectMaps(const MaterialPrior& prior, const capture::Maps& maps, LatentSpace space,
                       int iterations, const FitObserver& observer = {});

}  // namespace lacquer::materialgan
