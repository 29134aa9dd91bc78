#include "pbrt/materials/index_of_refraction.h"

#include <fmt/format.h>

namespace lacquer {

IndexOfRefraction IndexOfRefraction::Read(const Params& params, const std::string& name) {
    IndexOfRefraction index;
    if (const std::optional<float> value = params.GetOptionalFloat(name)) {
        if (!(*value >= 0) || !std::isfinite(*value))
            params.Fail(name,
                        fmt::format("\"{}\" is {}; expected a positive index of refraction", name, *value));
        index.spectrum_ = std::make_shared<ConstantSpectrum>(*value);
        return index;
    }
    if (std::shared_ptr<const Spectrum> spectrum = params.GetSpectrum(name, SpectrumKind::Unbounded))
        index.spectrum_ = std::move(spectrum);
    return index;
}

float IndexOfRefraction::At(SampledWavelengths& lambda) const {
    const float eta = spectrum_->Evaluate(lambda[0]);
    if (!spectrum_->IsConstant()) lambda.TerminateSecondary();
    return Limited(eta);
}

}  // namespace lacquer
