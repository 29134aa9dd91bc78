// The auxiliary outputs that are sums of numbers: what each adds for a sample, and what a pixel's sums mean.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/registry.h"
#include "pbrt/film/first_hit.h"

namespace lacquer {

/// What outputs are expressed in.
struct AovSpaces {
    const ColorSpace* color = nullptr;
    Transform renderFromWorld;
    AnimatedTransform renderFromCamera;
    /// Positions and normals in camera space rather than in the world's.
    bool cameraSpace = false;
};

/// One camera sample, and where it is looked at from.
struct AovSample {
    const FirstHit& hit;
    SampledSpectrum L;
    const SampledWavelengths& lambda;
    Vec3 response;  ///< of the sensor; only "sensorvariance" asks
    const ColorSpace& color;
    Transform outputFromRender;  ///< world or camera space
    Transform cameraFromRender;
    float weight = 1;  ///< of the filter, as colours have it
};

/// Samples of a pixel so far.
struct AovCounts {
    double samples = 0, hits = 0;
};

/// That an output can have.
inline constexpr int kMaxAovSums = 8;

/// One output. Its sums belong to one pixel and start at 0.
struct AovOutput {
    std::vector<std::string> channels;
    int numSums = 0;
    bool needsFloats = false;  ///< 16 bits are too few for it
    FirstHitNeeds needs = {};  ///< `any`: `add` sees only samples that hit something
    bool isInternal = false;   ///< part of a film, and no name of the command line
    bool isOfHalf = false;     ///< of the first half of the samples of each pixel alone
    /// What a sample adds to the sums; `terms` are 0 before.
    void (*add)(const AovSample& sample, double* terms) = nullptr;
    void (*develop)(const ColorSpace& color, const AovCounts& counts, const double* sums,
                    float* out) = nullptr;
};

/// By the names of the command line: a file in aovs/ for each family.
struct AovKind {
    static constexpr const char* kKind = "auxiliary output";
    using Factory = AovOutput (*)();
};

/// The components as three terms.
inline void SetTo(double* terms, Vec3 v) {
    for (int i = 0; i < 3; ++i) terms[i] = double(v[i]);
}

}  // namespace lacquer
