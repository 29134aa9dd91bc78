#include "pbrt/samplers/sampler_params.h"

#include <fmt/format.h>

namespace lacquer {

std::optional<int> CheckedOverride(const SamplerArgs& args) {
    if (!args.samplesPerPixel) return std::nullopt;
    const int count = *args.samplesPerPixel;
    if (count < 1 || count > kMaxSamplesPerPixel)
        throw SceneError({},
                         fmt::format("{} samples per pixel; expected 1 to {}", count, kMaxSamplesPerPixel));
    return count;
}

int ReadPixelSamples(const SamplerArgs& args, int fallback) {
    const int inScene = args.params.GetIntInRange("pixelsamples", fallback, 1, kMaxSamplesPerPixel);
    return CheckedOverride(args).value_or(inScene);
}

int ReadSeed(const SamplerArgs& args) { return args.params.GetInt("seed", args.seed); }

Randomization ReadRandomization(const SamplerArgs& args, const std::vector<std::string>& choices) {
    const std::string name = args.params.GetChoice("randomization", choices.front(), choices);
    if (name == "permutedigits") return Randomization::PermuteDigits;
    if (name == "fastowen") return Randomization::FastOwen;
    return name == "owen" ? Randomization::Owen : Randomization::None;
}

const std::vector<std::string>& BinaryRandomizations() {
    static const std::vector<std::string> choices = {"fastowen", "none", "permutedigits", "owen"};
    return choices;
}

}  // namespace lacquer
