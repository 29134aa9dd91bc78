// Gaussian lobes of rough boundaries, from fitted tables: what products of several events are built of.
#pragma once

#include "gaussfit/lobe/gaussian_mixture.h"
#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::gaussfit {

/// What happens to light at a boundary. Entering: refraction from the smaller to the larger index.
enum class LobeEvent { Reflection, Entering, Leaving };

/// The mixture that was fitted to f(w, .)|cos|^c (c = 4 for reflections, 2 for transmissions; Fresnel's
/// factor is in transmissions only) as a function of the slope (x/z, y/z) of the other direction [Xia et al.
/// 2020, eq. 16]. A direction and its opposite have the same slope, so the mixture says nothing about the
/// sign of z. Normalised over the plane of slopes.
/// @param w    unit, away from the surface, either sign of z
/// @param eta  index on the far side over index on the side of w; not looked at for reflections
/// False where the tables do not reach (alpha, eta, angle) or the surface is anisotropic; then nothing is
/// set. Thread-safe. The first call reads the tables, whose errors are in lobe_table.h.
bool FindLobe(const MicrofacetSurface& surface, LobeEvent event, float eta, Vec3 w, GaussianMixture* lobe);

}  // namespace lacquer::gaussfit
