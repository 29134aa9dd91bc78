// Sampler "pmj02bn": (0,2)-sequences, one for every pair of dimensions.
//
//   "integer pixelsamples"  16            samples per pixel, up to 65536; powers of 4 are best
//   "integer seed"          the option's  of the random numbers
//
// pbrt-v4 has tables of progressive multi-jittered points [Christensen et al. 2018] and of blue noise under
// this name; here the points are those of "paddedsobol" with hashed Owen scrambling, which are stratified
// alike: any 4^k first samples have one point in each elementary interval. What they converge to is the same.
// Error is not distributed as blue noise over the pixels.
#include <fmt/format.h>

#include <bit>

#include "pbrt/core/progress.h"
#include "pbrt/samplers/padded_sobol.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {
namespace {

/// The format's limit.
constexpr int kMaxSamples = 65536;

std::unique_ptr<Sampler> CreatePmj02bn(const SamplerArgs& args) {
    const int samples = ReadPixelSamples(args, 16);
    const std::string place = args.samplesPerPixel ? "" : args.params.LocOf("pixelsamples").ToString() + ": ";
    if (samples > kMaxSamples) {
        const std::string problem =
            fmt::format("{} samples per pixel; sampler \"pmj02bn\" has at most {}", samples, kMaxSamples);
        if (args.samplesPerPixel) throw SceneError({}, problem);
        args.params.Fail("pixelsamples", problem);
    }
    const bool isPowerOfFour =
        std::has_single_bit(unsigned(samples)) && std::countr_zero(unsigned(samples)) % 2 == 0;
    if (!isPowerOfFour && args.observer)
        args.observer->Warn(fmt::format(
            "{}warning: {} samples per pixel; sampler \"pmj02bn\" is at its best with powers of 4", place,
            samples));
    return std::make_unique<PaddedSobolSampler>(samples, Randomization::FastOwen, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "pmj02bn", CreatePmj02bn);

}  // namespace lacquer
