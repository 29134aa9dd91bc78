// Light that enters a surface at one point and leaves it at another.
#pragma once

#include <optional>

#include "pbrt/base/bxdf.h"
#include "pbrt/core/arena.h"

namespace lacquer {

/// Where exit points are looked for: every hit of this segment with the same material is one.
struct ProbeSegment {
    Point3 start{0};
    Vec3 direction{0, 0, 1};  ///< unit
    float length = 0;
    float radius = 0;  ///< of the neighbourhood: the segment is a chord of a sphere around the entry
};

/// One exit point, as light that enters at the entry point sees it.
struct BSSRDFValue {
    SampledSpectrum Sp;  ///< share of the power let in that leaves here, per unit of area
    /// Density over area of the exit points of SampleProbe(), summed over all hits of a segment, had it drawn
    /// for the one or the other wavelength. It draws for the first one.
    SampledSpectrum pdf;
};

/// Scattering below one surface point, in separable form S = (1 - Fr(wo)) Sp(po, pi) Sw(wi)
/// [Jensen et al. 2001]: the BxDF of the surface has the first factor (as refraction into it), Evaluate() the
/// second and ExitBxDF() the third. Lives in an Arena, like a BxDF. Radiance mode: the path comes from the
/// camera, "entry" is where it does, "exit" where it goes on.
class BSSRDF {
  public:
    /// A segment through the neighbourhood of the entry. Empty if nothing is let out (the path ends).
    virtual std::optional<ProbeSegment> SampleProbe(float uAxis, Point2 u) const = 0;
    /// @param n  geometric normal at the exit point p
    virtual BSSRDFValue Evaluate(Point3 p, Normal3 n) const = 0;
    /// Integral of Sp over a flat surface.
    virtual SampledSpectrum EffectiveAlbedo() const = 0;
    /// How light leaves, in the frame of the exit point with wo along z. Includes the eta^2 that radiance
    /// lost at the entry.
    virtual BxDF* ExitBxDF(Arena& arena) const = 0;

  protected:
    ~BSSRDF() = default;  // never destroyed through the base: the arena forgets objects
};

}  // namespace lacquer
