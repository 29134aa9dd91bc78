// Numbers about a lobe: energies with errors, reciprocity, cost.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "measure/bsdf_subject.h"
#include "measure/direction_guide.h"
#include "pbrt/core/progress.h"

namespace lacquer::measure {

/// A lobe that has one direction only.
struct SpecularPeak {
    Vec3 w{0, 0, 1};
    glm::dvec3 energy{0};  ///< its part of the light, linear sRGB
};

/// What a fixed direction w looks into: with `Importance`, w is where the light comes from, and energies are
/// parts of the light's power. With `Radiance`, w is the side of the camera, and energies are what a white
/// environment (of radiance n^2 on a side of index n) gives. For lossless surfaces all are 1.
struct LobeQuery {
    const BsdfSubject& subject;
    Vec3 w;
    TransportMode mode = TransportMode::Importance;
    uint64_t seed = 0;
    Observer* observer = nullptr;  ///< is told of each batch; may be null
};

/// Found by Sample().
struct SampledLobe {
    ColorMean reflected, transmitted;              ///< all light
    ColorMean smoothReflected, smoothTransmitted;  ///< what is not in specular peaks
    std::vector<SpecularPeak> peaks;               ///< the strongest ones, strongest first
    std::vector<Vec3> directions;                  ///< of a part of the non-specular samples
    double eta = 1;          ///< index on the side that w is not on over that on its own
    int64_t badSamples = 0;  ///< not finite or negative; counted as black
};
/// Follows `numBatches` times one sample at each set of wavelengths.
SampledLobe SampleLobe(const LobeQuery& query, int64_t numBatches);

/// Integrals of Evaluate() over the two hemispheres.
struct LobeEnergy {
    ColorMean reflected, transmitted;
    int64_t badSamples = 0;
};
/// Unbiased, with directions from `guide`. The means are over 64 independent parts of the batches, and so
/// Count() is 64. @param eta  as SampledLobe found it
LobeEnergy IntegrateLobe(const LobeQuery& query, const DirectionGuide& guide, double eta, int64_t numBatches);
/// A guide for a query, learnt from its samples.
DirectionGuide LearnGuide(const LobeQuery& query, const SampledLobe& lobe);

/// How far f(wo, wi) and f(wi, wo), scaled by the squared indices of their sides, are apart.
struct Reciprocity {
    int numPairs = 0;         ///< of directions at which f is not 0 both ways round
    double meanRelative = 0;  ///< mean of |a - b| / ((a + b) / 2), in luminance
    double maxRelative = 0;
    double expectedMean = 0;   ///< of meanRelative if only noise were there
    double largestSigmas = 0;  ///< largest |a - b| in its standard errors; 0 if there is no noise
};
/// In radiance mode. Stochastic models are averaged over `numBatches`.
Reciprocity MeasureReciprocity(const BsdfSubject& subject, Vec3 w, double eta, int numPairs,
                               int64_t numBatches, uint64_t seed);

/// Of one thread, measured by the clock.
struct EvaluationCost {
    double evaluateNs = 0;  ///< f and pdf
    double evaluateWithoutPdfNs = 0;
    double sampleNs = 0;
    double noise = 0;  ///< standard deviation of one evaluation over its mean, where the samples go; 0: exact
};
EvaluationCost MeasureCost(const LobeQuery& query, const SampledLobe& lobe);

/// A colour is what a sample may be: finite and not negative.
inline bool IsUsable(SampledSpectrum s) { return s.IsValid(); }

}  // namespace lacquer::measure
