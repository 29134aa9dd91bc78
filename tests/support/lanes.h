// Spectra of tests.
#pragma once

#include <array>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer::test {

/// Four values in turn in the elements of a spectrum.
inline SampledSpectrum Lanes(float a, float b, float c, float d) {
    return MakeLanes<SampledSpectrum::Lanes>(
        [values = std::array{a, b, c, d}](int lane) { return values[size_t(lane % 4)]; });
}

}  // namespace lacquer::test
