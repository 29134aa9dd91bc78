// Gradient noise and its sums over octaves.
#pragma once

#include "pbrt/core/params.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Gradient noise in about [-1, 1], zero at integer points, twice differentiable; 0 far away (beyond 2^24,
/// where floats have no fractions) and for NaN. Source: [Perlin 2002, Improving Noise].
float Noise(Point3 p);
/// Its slice z = 1/2.
inline float Noise(float x, float y) { return Noise(Point3(x, y, 0.5f)); }

/// Most octaves that are ever summed: at the 32nd, coordinates are 1.99^32 = 4e9 times as large, where
/// Noise() is zero.
inline constexpr int kMaxOctaves = 32;

/// How a sum over octaves is made.
struct OctaveParams {
    float omega = 0.5f;  ///< weight of an octave relative to the one before
    int octaves = 8;     ///< in [0, kMaxOctaves]
    /// `"octaves"` (default 8, limited to kMaxOctaves) and `"roughness"` (default 0.5, in [-10, 10]).
    /// Errors: SceneError for a negative count or a roughness outside.
    static OctaveParams Read(const Params& params);
};

/// sum of omega^i Noise(1.99^i p) over as many octaves as the footprint dpdx, dpdy leaves visible; the last
/// one fades.
float FractionalBrownianMotion(Point3 p, Vec3 dpdx, Vec3 dpdy, const OctaveParams& params);
/// The same of |Noise|; octaves too fine for the footprint are replaced by their mean, 0.2.
float Turbulence(Point3 p, Vec3 dpdx, Vec3 dpdy, const OctaveParams& params);

}  // namespace lacquer
