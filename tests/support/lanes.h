// Spectra of tests.
#pragma once

#include <array>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer::test {

/// Four values in the first elements of a spectrum, and in the others again, backwards: no element is what
/// the fourth one before it is.
inline SampledSpectrum Lanes(float a, float b, float c, float d) {
    return MakeLanes<SampledSpectrum::Lanes>([values = std::array{a, b, c, d}](int lane) {
        return values[size_t(lane / 4 % 2 == 0 ? lane % 4 : 3 - lane % 4)];
    });
}

}  // namespace lacquer::test
