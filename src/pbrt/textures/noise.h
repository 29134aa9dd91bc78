// Gradient noise summed over octaves.
#pragma once

#include "pbrt/core/noise.h"
#include "pbrt/core/params.h"

namespace lacquer {

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
