// Gradient noise: the irregularity of textures and clouds.
#pragma once

#include "pbrt/core/vec.h"

namespace lacquer {

/// Gradient noise in about [-1, 1], zero at integer points, twice differentiable; 0 far away (beyond 2^24,
/// where floats have no fractions) and for NaN. Source: [Perlin 2002, Improving Noise].
float Noise(Point3 p);
/// Its slice z = 1/2.
inline float Noise(float x, float y) { return Noise(Point3(x, y, 0.5f)); }
/// Its gradient; 0 where Noise() is 0 for want of digits.
Vec3 NoiseGradient(Point3 p);

}  // namespace lacquer
