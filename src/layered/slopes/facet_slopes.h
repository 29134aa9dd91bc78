// How the slopes of an interface's facets are spread, in the stack's frame, and which of them a direction
// sees. Gaussian for Beckmann's distribution; of Trowbridge and Reitz' the matrix of their ellipse over 2
// stands for the covariance.
#pragma once

#include "layered/stack.h"
#include "pbrt/scattering/slopes.h"

namespace lacquer::layered {

/// Covariance of the facets' slopes about that of the interface's normal: alpha^2/2 along its axes.
inline Symmetric2 FacetCovariance(const StackInterface& interface, const MicrofacetSurface& surface) {
    Symmetric2 covariance{0.5f * Sqr(surface.alphaX), 0, 0.5f * Sqr(surface.alphaY)};
    if (interface.hasOwnFrame) {
        const Symmetric2 flat = covariance;
        covariance = Symmetric2{}
                         .PlusSquare(flat.xx, PlanarPart(interface.frame.x))
                         .PlusSquare(flat.yy, PlanarPart(interface.frame.y));
    }
    return covariance;
}

/// Visible facets have the density (1 + s.m)+ times that of all facets, s being the slope of the direction
/// that sees them. For a Gaussian of covariance C its peak is at t C s; this is t times `scale`.
/// @param q  s'C s
inline float ModeOfVisible(float q, float scale = 1) { return 2 * scale / (1 + std::sqrt(1 + 4 * q)); }

}  // namespace lacquer::layered
