// Sampler "paddedsobol": the first two dimensions of the Sobol sequence for every pair of dimensions
// (padded_sobol.h).
//
//   "integer pixelsamples"  16            samples per pixel, up to 2^24
//   "string randomization"  fastowen      or "permutedigits", "none", "owen"
//   "integer seed"          the option's  of the random numbers
#include "pbrt/samplers/padded_sobol.h"

#include "pbrt/samplers/sampler_params.h"

namespace lacquer {
namespace {

std::unique_ptr<Sampler> CreatePaddedSobol(const SamplerArgs& args) {
    const int samplesPerPixel = ReadPixelSamples(args, 16);
    const Randomization randomization = ReadRandomization(args, BinaryRandomizations());
    return std::make_unique<PaddedSobolSampler>(samplesPerPixel, randomization, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "paddedsobol", CreatePaddedSobol);

}  // namespace lacquer
