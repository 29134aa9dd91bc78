// The colour of one camera sample, for those who have no sensor.
#pragma once

#include "pbrt/core/color_space.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/spectrum.h"

namespace lacquer {

/// An estimate of XYZ from the wavelengths of one sample.
inline XYZ EstimateXYZ(const SampledSpectrum& s, const SampledWavelengths& lambda) {
    const SampledSpectrum weighted = SafeDivide(s, lambda.Pdf()) / kCieYIntegral;
    return {(weighted * CieX().Sample(lambda)).Average(), (weighted * CieY().Sample(lambda)).Average(),
            (weighted * CieZ().Sample(lambda)).Average()};
}

}  // namespace lacquer
