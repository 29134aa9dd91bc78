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
    index.spectrum_ = params.GetSpectrum(name, SpectrumKind::Unbounded);
    if (!index.spectrum_) index.spectrum_ = std::make_shared<ConstantSpectrum>(1.5f);
    return index;
}

float IndexOfRefraction::At(SampledWavelengths& lambda) const {
    const float eta = spectrum_->Evaluate(lambda[0]);
    if (!spectrum_->IsConstant()) lambda.TerminateSecondary();
    if (eta == 0 || std::isnan(eta)) return 1;
    return std::clamp(eta, 1e-3f, 1e3f);
}

}  // namespace lacquer
