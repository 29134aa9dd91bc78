// Random phases, one for each frequency.
#pragma once

#include "estimate/fourier/fft.h"

namespace lacquer::estimate {

/// Half spectrum of the real part of a sum of waves of amplitude one with random phases:
/// (exp(i phi(k)) + exp(-i phi(-k))) / 2. The phase of a frequency depends on the stream and the frequency,
/// so that images of two sizes share their low frequencies. The frequency 0 has amplitude 0.
void FillPhases(uint64_t stream, ComplexGrid* half);

/// Frequency of a row of a spectrum of `size` rows, in cycles over the image.
inline int SignedFrequency(int row, int size) { return row <= size / 2 ? row : row - size; }

}  // namespace lacquer::estimate
