#include "layered/chains/pair_walk.h"

namespace lacquer {

bool FindLobeOf(const MicrofacetSurface& surface, bool transmits, Vec3 w, GaussianMixture* lobe) {
    if (!transmits) return FindLobe(surface, LobeEvent::Reflection, 1, w, lobe);
    if (surface.eta == 0) return false;
    // surface.eta is below over above.
    const float eta = w.z > 0 ? surface.eta : 1 / surface.eta;
    return FindLobe(surface, eta > 1 ? LobeEvent::Entering : LobeEvent::Leaving, eta, w, lobe);
}

}  // namespace lacquer
