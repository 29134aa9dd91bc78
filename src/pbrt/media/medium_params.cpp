#include "pbrt/media/medium_params.h"

#include <fmt/format.h>

#include "pbrt/base/light.h"
#include "pbrt/core/invertible.h"
#include "pbrt/phases/bulk.h"
#include "pbrt/phases/phase_params.h"

namespace lacquer {

namespace {

/// The spectrum under `name`, or that of the preset, or 1.
DenselySampledSpectrum ReadSpectrum(const Params& params, std::string_view name,
                                    const std::optional<RGB>& preset) {
    const std::unique_ptr<Spectrum> given = params.GetSpectrum(name, SpectrumKind::Unbounded);
    if (preset && given)
        params.Fail(
            name, fmt::format("\"{}\" is given beside \"preset\", which says it as well; remove one of them",
                              name));
    if (preset)
        return DenselySampledSpectrum(*ColorSpace::SRGB().MakeSpectrum(*preset, SpectrumKind::Unbounded));
    if (given) return DenselySampledSpectrum(*given);
    return DenselySampledSpectrum(ConstantSpectrum(1));
}

/// Errors: SceneError at the parameter `name`.
DenselySampledSpectrum ScaledCoefficient(DenselySampledSpectrum sigma, float scale, const Params& params,
                                         std::string_view name) {
    for (const float value : sigma.Values())
        if (!(value >= 0) || !std::isfinite(value * scale))
            params.Fail(
                name, fmt::format("\"{}\" must be finite and not negative at all wavelengths, found {}", name,
                                  value));
    sigma.Scale(scale);
    return sigma;
}

/// Those of the phase function's file, or else `"sigma_a"` and `"sigma_s"`.
Coefficients ScaledCoefficients(const Params& params, const PhaseModel& phase, float scale,
                                const ScatteringPreset* preset) {
    if (const auto* bulk = BulkPhaseModel::Of(phase)) {
        Coefficients coefficients{bulk->SigmaA(), bulk->SigmaS()};
        coefficients.sigma_a.Scale(scale);
        coefficients.sigma_s.Scale(scale);
        return coefficients;
    }
    std::optional<RGB> sigma_a, sigma_s;
    if (preset) sigma_a = preset->sigma_a, sigma_s = preset->reducedSigma_s;
    return {ScaledCoefficient(ReadSpectrum(params, "sigma_a", sigma_a), scale, params, "sigma_a"),
            ScaledCoefficient(ReadSpectrum(params, "sigma_s", sigma_s), scale, params, "sigma_s")};
}

Coefficients RequireFiniteExtinction(const Params& params, Coefficients coefficients, float density,
                                     std::string_view cause) {
    // Twice: room for what is computed of it.
    const float sigma_t = coefficients.sigma_a.MaxValue() + coefficients.sigma_s.MaxValue();
    if (!std::isfinite(2 * sigma_t * std::max(density, 1.f)))
        params.Fail(cause, "the coefficients of this medium are too large for floats");
    return coefficients;
}

}  // namespace

float ReadNonNegative(const Params& params, std::string_view name, float fallback) {
    const float value = params.GetFloat(name, fallback);
    if (!(value >= 0)) params.Fail(name, fmt::format("\"{}\" must not be negative, found {}", name, value));
    return value;
}

Coefficients ReadCoefficients(const Params& params, float largestDensity, std::string_view cause,
                              const PhaseModel& phase, const ScatteringPreset* preset) {
    const float scale = ReadNonNegative(params, "scale", 1);
    return RequireFiniteExtinction(params, ScaledCoefficients(params, phase, scale, preset), largestDensity,
                                   cause);
}

std::optional<ScatteringPreset> ReadPreset(const Params& params) {
    const std::optional<std::string> name = params.GetOptionalString("preset");
    if (!name) return std::nullopt;
    const std::optional<ScatteringPreset> preset = FindScatteringPreset(*name);
    if (!preset)
        params.Fail("preset", fmt::format("unknown preset \"{}\" of a scattering medium{}", Excerpt(*name),
                                          DidYouMean(*name, ScatteringPresetNames())));
    return preset;
}

Coefficients ReadUnscaledCoefficients(const Params& params, const PhaseModel& phase) {
    const bool isBulk = BulkPhaseModel::Of(phase);
    const float scale = isBulk ? ReadNonNegative(params, "scale", 1) : 1;
    return RequireFiniteExtinction(params, ScaledCoefficients(params, phase, scale, nullptr), 1,
                                   isBulk ? "bulk" : "sigma_s");
}

namespace {

/// A medium, to those who read the parameters of its phase function.
class MediumOwner final : public PhaseOwner {
  public:
    explicit MediumOwner(const NamedMedia* named) : named_(named) {}
    const char* Kind() const override { return "medium"; }
    const char* KindOfMany() const override { return "media"; }
    TextureLibrary* Textures() const override { return nullptr; }
    const PhaseModel* Find(const Params& params, const std::string& name) const override {
        const NamedMedia none;
        const NamedMedia& named = named_ ? *named_ : none;
        if (const auto it = named.find(name); it != named.end())
            return it->second ? &it->second->GetPhaseModel() : nullptr;
        std::vector<std::string> names;
        for (const auto& [known, medium] : named) names.push_back(known);
        params.Fail("phases", fmt::format("no medium named \"{}\" stands before this one{}", Excerpt(name),
                                          DidYouMean(name, names)));
    }

  private:
    const NamedMedia* named_;
};

}  // namespace

MediumPhase ReadMediumPhase(const MediumArgs& args) {
    const MediumOwner owner(args.named);
    auto model = ReadPhaseModel({args.params, owner}, "hg");
    if (model->IsOriented()) RequireInvertible(args.params, args.renderFromMedium);
    return {std::move(model), args.renderFromMedium};
}

std::optional<DenselySampledSpectrum> ReadMediumEmission(const Params& params) {
    const float scale = ReadNonNegative(params, "Lescale", 1);
    const std::unique_ptr<Spectrum> given = params.GetSpectrum("Le", SpectrumKind::Illuminant);
    if (!given || scale == 0 || given->MaxValue() == 0) return std::nullopt;
    DenselySampledSpectrum Le(*given);
    Le.Scale(EmissionScale(*given, params, "Le", scale));
    if (!std::isfinite(Le.MaxValue()))
        params.Fail("Le", "the emission of this medium is too large for floats");
    return Le;
}

}  // namespace lacquer
