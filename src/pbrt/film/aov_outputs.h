// The auxiliary outputs that are sums of numbers: what each adds for a sample, and what a pixel's sums mean.
#pragma once

#include <span>
#include <string>
#include <vector>

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
};

/// Samples of a pixel so far.
struct AovCounts {
    double samples = 0, hits = 0;
};

/// One output. Its sums start at 0 and belong to one pixel.
struct AovOutput {
    std::string name;  ///< on the command line
    std::vector<std::string> channels;
    int numSums;
    bool ofHits;       ///< true: `add` sees only samples that hit something
    bool needsFloats;  ///< true: 16 bits are too few for it
    /// @param counts  of the pixel, this sample included
    void (*add)(const AovSample& sample, const AovCounts& counts, double* sums);
    void (*develop)(const ColorSpace& color, const AovCounts& counts, const double* sums, float* out);
};

/// All of them, in the order in which messages list them. The last ones ("slope", "sensorvariance") are parts
/// of the gbuffer film and no names of the command line.
std::span<const AovOutput> AovOutputs();
/// Null if there is none of that name.
const AovOutput* FindAovOutput(const std::string& name);

}  // namespace lacquer
