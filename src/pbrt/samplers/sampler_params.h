// Parameters that several samplers share.
#pragma once

#include <string>
#include <vector>

#include "pbrt/base/sampler.h"
#include "pbrt/samplers/low_discrepancy.h"

namespace lacquer {

/// Upper limit of samples a pixel.
inline constexpr int kMaxSamplesPerPixel = 1 << 24;

/// "integer pixelsamples", overridden by the arguments. Errors: SceneError outside [1, kMaxSamplesPerPixel].
int ReadPixelSamples(const SamplerArgs& args, int fallback);
/// The override of the arguments, if any. Errors: as above.
std::optional<int> CheckedOverride(const SamplerArgs& args);
/// "integer seed".
int ReadSeed(const SamplerArgs& args);
/// "string randomization", one of `choices`; the first one is the default. Errors: SceneError for any other.
Randomization ReadRandomization(const SamplerArgs& args, const std::vector<std::string>& choices);
/// The choices of the samplers in base 2.
const std::vector<std::string>& BinaryRandomizations();

}  // namespace lacquer
