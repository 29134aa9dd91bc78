// Maps from photographs, texel by texel [Guo et al. 2020b, the baseline and the refinement of their results]:
// Adam on the squared differences of encoded values, with total variation to tie neighbours together where
// one texel's photographs leave something open.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/maps.h"
#include "capture/svbrdf/fit_checkpoint.h"
#include "capture/svbrdf/rectified_image.h"
#include "capture/views.h"
#include "pbrt/core/progress.h"

namespace lacquer::capture {

struct FitSettings {
    /// The published 1000 gain nothing from nine photographs, and lose with three: what these leave open
    /// drifts.
    int iterations = 500;
    /// Of Adam, for stored values; it falls to nothing over the last part of the iterations.
    double learningRate = 0.02;
    double fallingPart = 0.4;  ///< in [0,1]; 0: it does not fall
    /// Weight of the mean absolute difference between neighbours, all channels together, next to the mean
    /// squared difference from the photographs; 0: texels do not know each other.
    double totalVariation = 0.003;
    /// Also fit the light's power, in each colour. Photographs from the light's own place hardly tell a
    /// brighter light from a darker sample: what tells is a sample that is white somewhere.
    bool fitLightPower = false;
    /// Iterations from one look at the photographs for tests to the next, each of which takes as long as some
    /// iterations; 0: none.
    int testEvery = 0;
    /// After each iteration, from the calling thread; may be empty.
    std::function<void(const FitStep&)> afterStep = {};
    /// Where the fit's state goes at times and at its end, and where a fit of this name and size goes on
    /// from: with the bits that it would have had, and with the steps that were done told again. Null:
    /// nowhere.
    FitCheckpoint* checkpoint = nullptr;
    std::string name = "texels";
};

struct FitResult {
    enum class End {
        Finished,
        Stopped,   ///< as the observer wished
        NotFinite  ///< the loss was no number: the maps are the last ones before
    };
    Maps maps;
    std::array<double, 3> lightPower{};
    std::vector<double> inputRmse;  ///< of each iteration, before its step
    End end = End::Finished;
    bool isCoarseToFine = false;  ///< of FitFromConstant()
};

/// A start that knows nothing, as linear values. Where a lobe is so narrow that a photograph does not show
/// it, nothing says in which direction to go: the published roughness, 0.2, leaves an error in novel views
/// that is twice as large.
struct ConstantStart {
    double albedo = 0.2177;  ///< in the middle of stored values
    double specular = 0.04;  ///< of most dielectrics
    double roughness = 0.5;  ///< alpha is its square
};
Maps ConstantMaps(int size, const ConstantStart& start = {});

/// Maps of more or fewer texels by Lanczos' window of four lobes, values clamped to [-1,1]: those of a
/// finished fit, to go on at the size of the photographs. @param size  above 0
Maps ResizeMaps(const Maps& maps, int size);

/// Errors: std::invalid_argument if no view is to be fitted, or numbers and sizes do not match.
void CheckFit(const ViewSet& views, std::span<const RectifiedImage> images, int size);

/// Fits maps to the photographs that are not for tests.
/// @param images  one for each view, all of the size of the start
/// @param start   values in [-1,1]
/// The bits of the result depend neither on the number of threads nor on the order in which they work.
/// Errors: those of CheckFit().
FitResult FitMaps(const ViewSet& views, std::span<const RectifiedImage> images, const Maps& start,
                  const FitSettings& settings, Observer* observer = nullptr);
/// What FitMaps() makes small: the mean squared difference from the photographs that are fitted, and the
/// total variation by its weight. The light's power is that of the views. Errors: those of CheckFit().
double FitObjective(const ViewSet& views, std::span<const RectifiedImage> images, const Maps& maps,
                    double totalVariation);

/// The same from nothing: first from photographs of a half and a quarter of the size, with half of the
/// iterations each, as far as the size can be halved and 8 texels are left. Where a highlight is seen, it
/// tells the roughness of its surroundings before they tell something else. (The made-up materials, with
/// noise: 0.046 and 0.023 without, 0.036 and 0.016 with; twice the iterations instead: 0.043 and 0.021.) The
/// steps of all sizes are counted on, and Stopped or NotFinite ends all.
FitResult FitFromConstant(const ViewSet& views, std::span<const RectifiedImage> images,
                          const ConstantStart& start, const FitSettings& settings,
                          Observer* observer = nullptr);

/// What a capture without a generator takes: of FitFromConstant() and of FitMaps() at one size the fit with
/// the lower objective; with one photograph that at one size. From coarse to fine is better where maps have
/// large parts alike, at one size where they vary from texel to texel, and the objective tells. (Novel views
/// of made-up materials of the first kind from three photographs with noise: 0.049 and 0.071; of procedural
/// ones: docs/capture-figures.md.) One photograph is explained by anything, and coarse to fine goes further
/// from the start: 0.149 and 0.138. The steps that are told, at the end, and those of the result are those of
/// the fit that is taken.
FitResult FitTexels(const ViewSet& views, std::span<const RectifiedImage> images, const ConstantStart& start,
                    const FitSettings& settings, Observer* observer = nullptr);

/// A fit goes on with twice the texels: ResizeMaps(), and then some iterations at half of the rate, with the
/// light as it was found [Guo et al. 2020b].
/// @param images    of twice the size of the fit
/// @param settings  its iterations are those after the doubling; with 0 there is no fit and no observer
FitResult FitDoubled(const FitResult& coarse, const ViewSet& views, std::span<const RectifiedImage> images,
                     FitSettings settings, Observer* observer = nullptr);

}  // namespace lacquer::capture
