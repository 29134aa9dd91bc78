#include "layered/chains/pair_walk.h"

namespace lacquer {

bool FindLobeSurface(const StackInterface& interface, MicrofacetSurface* surface) {
    const SurfaceModel model = interface.bxdf->Model();
    const auto* found = std::get_if<MicrofacetSurface>(&model);
    if (!found || found->alphaX != found->alphaY) return false;
    // A tangent may be turned, the normal may not lean.
    if (interface.isTurned && !(interface.frame.z.x == 0 && interface.frame.z.y == 0)) return false;
    *surface = *found;
    return true;
}

bool FindLobeOf(const MicrofacetSurface& surface, bool transmits, Vec3 w, GaussianMixture* lobe) {
    if (!transmits) return FindLobe(surface, LobeEvent::Reflection, 1, w, lobe);
    if (surface.eta == 0) return false;
    // surface.eta is below over above.
    const float eta = w.z > 0 ? surface.eta : 1 / surface.eta;
    return FindLobe(surface, eta > 1 ? LobeEvent::Entering : LobeEvent::Leaving, eta, w, lobe);
}

}  // namespace lacquer
