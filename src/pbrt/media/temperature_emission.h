// Emission of media that glow.
#pragma once

#include "pbrt/core/params.h"

namespace lacquer {

/// Light of a black body by a grid's temperatures.
class TemperatureEmission {
  public:
    /// `"temperatureoffset"` (or `"temperaturecutoff"`, default 0) and `"temperaturescale"` (1).
    explicit TemperatureEmission(const Params& params);

    /// Emission of a value of the grid: T = (value - offset) scale [K]; nothing up to 100 K.
    SampledSpectrum Le(float value, const SampledWavelengths& lambda) const;

  private:
    static constexpr float kLowestKelvin = 100;
    float offset_, scale_;
};

/// Planck's law at a temperature [K], > 0, divided by its own maximum, as BlackbodySpectrum; an exponential
/// per wavelength and no normalisation, for temperatures that change at each point. Relative error below
/// 1e-4.
SampledSpectrum NormalizedBlackbody(float kelvin, const SampledWavelengths& lambda);

}  // namespace lacquer
