// Periodic Gaussian noise with a spectrum that is a power of the frequency.
#pragma once

#include <vector>

#include "pbrt/core/rng.h"

namespace lacquer::materialgan {

/// A square of numbers, rows from the top; all of them are periodic.
using Field = std::vector<double>;

/// Amplitudes fall with frequency^-exponent. Mean 0, deviation 1.
/// @param size      a power of two
/// @param stretchX  above 1: slower along x than along y; below: faster
Field FractalNoise(int size, double exponent, double stretchX, Rng& rng);

/// Normal deviates.
double StandardNormal(Rng& rng);
double UniformIn(Rng& rng, double low, double high);
/// A whole number in [low, high].
int WholeIn(Rng& rng, int low, int high);

}  // namespace lacquer::materialgan
