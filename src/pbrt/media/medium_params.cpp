#include "pbrt/media/medium_params.h"

#include <fmt/format.h>

#include "pbrt/base/light.h"

namespace lacquer {

namespace {

/// The spectrum under `name`, 1 where absent, times `scale`.
DenselySampledSpectrum ReadCoefficient(const Params& params, std::string_view name, float scale) {
    const std::unique_ptr<Spectrum> given = params.GetSpectrum(name, SpectrumKind::Unbounded);
    const ConstantSpectrum one(1);
    DenselySampledSpectrum sigma(given ? *given : static_cast<const Spectrum&>(one));
    for (const float value : sigma.Values())
        if (!(value >= 0) || !std::isfinite(value * scale))
            params.Fail(
                name, fmt::format("\"{}\" must be finite and not negative at all wavelengths, found {}", name,
                                  value));
    sigma.Scale(scale);
    return sigma;
}

}  // namespace

float ReadNonNegative(const Params& params, std::string_view name, float fallback) {
    const float value = params.GetFloat(name, fallback);
    if (!(value >= 0)) params.Fail(name, fmt::format("\"{}\" must not be negative, found {}", name, value));
    return value;
}

Coefficients ReadCoefficients(const Params& params) {
    const float scale = ReadNonNegative(params, "scale", 1);
    return {ReadCoefficient(params, "sigma_a", scale), ReadCoefficient(params, "sigma_s", scale)};
}

HenyeyGreensteinPhase ReadPhase(const Params& params) {
    constexpr float kMaxG = 0.99f;
    return HenyeyGreensteinPhase(std::clamp(params.GetFloat("g", 0), -kMaxG, kMaxG));
}

std::optional<DenselySampledSpectrum> ReadMediumEmission(const Params& params) {
    const float scale = ReadNonNegative(params, "Lescale", 1);
    const std::unique_ptr<Spectrum> given = params.GetSpectrum("Le", SpectrumKind::Illuminant);
    if (!given || scale == 0 || given->MaxValue() == 0) return std::nullopt;
    DenselySampledSpectrum Le(*given);
    Le.Scale(EmissionScale(*given, params, "Le", scale));
    return Le;
}

}  // namespace lacquer
