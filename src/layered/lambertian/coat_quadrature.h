// What a rough dielectric coat transmits and reflects, by quadrature: the source of the coat tables.
#pragma once

#include <span>

#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// An isotropic boundary of microfacets. `eta`: index below over index above, > 1. alpha in [0, 1]; 0 is
/// smooth.
struct CoatSurface {
    MicrofacetModel model = MicrofacetModel::TrowbridgeReitz;
    double alpha = 0, eta = 1.5;
};

/// Light that comes from outside, at one angle, and what gets below the coat.
struct CoatEntry {
    /// Of walks that draw a visible normal and refract [1]: the share that gets in, F included.
    double probabilityIn = 0;
    /// The density with which light that comes from below, with a cosine lobe, is drawn towards this angle,
    /// times pi eta^2 [1]; with |cos| as a factor of it.
    double densityOut = 0;
    /// Mean of 1/cos below over the light that gets in.
    double meanPath = 1;
};

/// Light from below, with a cosine lobe, and what the coat reflects.
struct CoatReturn {
    double probabilityBack = 0;  ///< of walks, the share that comes down again
    double meanPath = 2;         ///< of 1/cos up plus 1/cos down over the light that comes back
};

/// The transmittances t into slabs of the optical thicknesses `taus` (vertical), shadowing and the way down
/// included: t(w) = int f*(w, u) exp(-tau/|cos u|) |cos u| eta^2 du, that is, E[weight exp(-tau/|cos u|)]
/// over visible normals. Errors below 4e-6, and below 3e-5 for cosTheta < 1e-4; 0.05 to 0.1 ms.
CoatEntry IntegrateEntry(const CoatSurface& surface, double cosTheta, std::span<const double> taus,
                         std::span<double> transmittances);

/// The diffuse internal reflectances R = 1/pi int int f(u, v) exp(-tau (1/|cos u| + 1/|cos v|)) |cos u cos v|
/// du dv, both ways through the slab included. Errors below 1e-6; 1 ms.
CoatReturn IntegrateReturn(const CoatSurface& surface, std::span<const double> taus,
                           std::span<double> reflectances);

}  // namespace lacquer::layered
