// Fits of one material whose maps are known, by texels and with a generator, and what they leave.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cmd/materialgan/evaluation_cases.h"
#include "cmd/materialgan/materialgan_arguments.h"
#include "materialgan/latent_fit.h"

namespace lacquer::cmd {

/// How maps are found.
enum FitMethod : size_t {
    Plain,         ///< texels, each by itself
    Smooth,        ///< texels with total variation
    CoarseToFine,  ///< the same from a quarter of the size
    BetterTexels,  ///< capture::FitTexels()
    LatentsOnly,   ///< what the generator can make
    Refined,       ///< and the photographs' corrections
    WithFallback,  ///< the better texels where DoubtOf() has a doubt
    NumMethods
};

/// What one method leaves of one material, or the mean over some.
struct FitErrors {
    double novel = 0, flip = 0, ssim = 0, input = 0, albedo = 0, normal = 0, roughness = 0, specular = 0,
           seconds = 0;
    void Add(const FitErrors& e, double weight) {
        novel += weight * e.novel;
        flip += weight * e.flip;
        ssim += weight * e.ssim;
        input += weight * e.input;
        albedo += weight * e.albedo;
        normal += weight * e.normal;
        roughness += weight * e.roughness;
        specular += weight * e.specular;
        seconds += weight * e.seconds;
    }
};
struct TrialResult {
    std::array<FitErrors, NumMethods> errors;
    double styleEnergy = 0, noiseEnergy = 0;
    bool isDoubted = false;
    capture::Maps texels, refined;  ///< of BetterTexels and Refined, as long as they are to be shown
};

/// The material has the size of the generator times a power of two. @param settings  of fits of texels
TrialResult RunTrial(const EvaluationCase& known, const materialgan::MaterialPrior& prior,
                     const MaterialganArguments& arguments, const capture::FitSettings& settings);

}  // namespace lacquer::cmd
