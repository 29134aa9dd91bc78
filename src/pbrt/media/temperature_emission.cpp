#include "pbrt/media/temperature_emission.h"

namespace lacquer {

SampledSpectrum NormalizedBlackbody(float kelvin, const SampledWavelengths& lambda) {
    // By Wien's displacement law, the spectrum over its maximum is a function of r = (wavelength of the
    // maximum) / lambda alone: r^5 (e^a - 1) / (e^(a r) - 1), where a = h c / (k 2.8977721e-3 m K).
    constexpr float kPeak = 2.8977721e6f;  // [nm K]
    constexpr float a = 4.9651142f, kExpAMinus1 = 142.32492f;
    // Above, 1 - e^(-ar) would lose its digits; the spectrum is a billionth there.
    constexpr float kHottest = 1e8f;
    const SampledSpectrum r = SampledSpectrum(kPeak / std::min(kelvin, kHottest)) / lambda.Lambda();
    const SampledSpectrum e = Exp(r * -a), r2 = r * r;
    return r2 * r2 * r * e * kExpAMinus1 / (SampledSpectrum(1) - e);
}

TemperatureEmission::TemperatureEmission(const Params& params) {
    const float cutoff = params.GetFloat("temperaturecutoff", 0);  // an older name
    offset_ = params.GetFloat("temperatureoffset", cutoff);
    scale_ = params.GetFloat("temperaturescale", 1);
}

SampledSpectrum TemperatureEmission::Le(float value, const SampledWavelengths& lambda) const {
    const float kelvin = (value - offset_) * scale_;
    return kelvin > kLowestKelvin ? NormalizedBlackbody(kelvin, lambda) : SampledSpectrum(0);
}

}  // namespace lacquer
