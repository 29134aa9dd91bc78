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
