#include "layered/paths/products/pair_walk.h"

#include "gaussfit/lobe/lobe_table.h"

namespace lacquer::layered {
namespace {

/// Of light from the side of index 1 to that of index `eta`.
gaussfit::LobeEvent RefractionOf(float eta) {
    return eta > 1 ? gaussfit::LobeEvent::Entering : gaussfit::LobeEvent::Leaving;
}

/// Variance of the facets' slopes along w times the square of w's own slope.
float Tilt2(const MicrofacetSurface& surface, Vec3 w) {
    return 0.5f * Sqr(surface.alphaX) * (1 - w.z * w.z) / (w.z * w.z);
}

}  // namespace

float GrazingOf(const MicrofacetSurface& surfaceA, Vec3 a, const MicrofacetSurface& surfaceB, Vec3 b) {
    const float tilt2 = std::max(Tilt2(surfaceA, a), Tilt2(surfaceB, b));
    return Sqr(tilt2) / (1 + Sqr(tilt2));
}

bool FindLobeOf(const MicrofacetSurface& surface, bool transmits, Vec3 w, gaussfit::GaussianMixture* lobe) {
    if (!transmits) return FindLobe(surface, gaussfit::LobeEvent::Reflection, 1, w, lobe);
    if (surface.eta == 0) return false;
    // surface.eta is below over above.
    const float eta = w.z > 0 ? surface.eta : 1 / surface.eta;
    return FindLobe(surface, RefractionOf(eta), eta, w, lobe);
}

bool HasLobeOf(const MicrofacetSurface& surface, bool transmits) {
    if (surface.alphaX != surface.alphaY || (transmits && surface.eta == 0)) return false;
    const gaussfit::LobeEvent event = transmits ? RefractionOf(surface.eta) : gaussfit::LobeEvent::Reflection;
    const gaussfit::LobeTable* table = gaussfit::EmbeddedLobeTable(surface.model, event);
    return table && table->Reaches({surface.alphaX, transmits ? surface.eta : 1, 1});
}

}  // namespace lacquer::layered
