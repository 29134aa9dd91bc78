#include "layered/paths/interface_path.h"

namespace lacquer::layered {
namespace {

/// @param goesDown  direction of the light before a transmission
bool SetEvent(const StackInterface& interface, bool transmits, bool goesDown, PathEvent& event) {
    const auto* surface = std::get_if<MicrofacetSurface>(&interface.model);
    if (!surface || !RelativeSlopes::ExistFor(interface)) return false;
    if (transmits && surface->eta == 0) return false;
    event.interface = &interface;
    event.surface = *surface;
    event.transmits = transmits;
    // surface.eta is below over above.
    event.eta = !transmits ? 1 : goesDown ? 1 / surface->eta : surface->eta;
    // Round ones do not turn, to the last digit.
    const float variance = 0.5f * Sqr(surface->alphaX);
    event.slopeCovariance =
        event.IsIsotropic() ? Symmetric2{variance, 0, variance} : FacetCovariance(interface, *surface);
    return true;
}

}  // namespace

bool FindShortestPath(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices, InterfacePath* path) {
    const int last = stack.Last(), first = stack.OuterTowards(wi), step = wi.z > 0 ? 1 : -1;
    const bool isReflection = SameHemisphere(wo, wi);
    const int numEvents = isReflection ? 3 : last + 1;
    if (last < 1 || numEvents > std::min(maxVertices, InterfacePath::kMaxShortestEvents)) return false;
    const std::array<int, InterfacePath::kMaxShortestEvents> sequence = {
        first, first + step, isReflection ? first : first + 2 * step};
    return SetInterfacePath(stack, wo, wi, std::span<const int>(sequence).first(size_t(numEvents)), path);
}

bool SetInterfacePath(const Stack& stack, Vec3 wo, Vec3 wi, std::span<const int> interfaces,
                      InterfacePath* path) {
    const size_t count = interfaces.size();
    path->numEvents = int(count);
    path->wi = wi;
    path->wo = wo;
    bool isDown = wi.z > 0;
    for (size_t k = 0; k < count; ++k) {
        const int at = interfaces[k];
        const bool isOuter = k == 0 || k + 1 == count;
        const bool transmits = isOuter || interfaces[k - 1] != interfaces[k + 1];
        if (!SetEvent(stack.interfaces[size_t(at)], transmits, isDown, path->events[k])) return false;
        if (!transmits) isDown = !isDown;
        if (k + 1 == count) break;
        path->slabs[k] = &stack.slabs[size_t(isDown ? at : at - 1)];
        path->signs[k] = isDown ? -1.f : 1.f;
    }
    return true;
}

SampledSpectrum PathContribution(const InterfacePath& path, const InnerDirections& inner, TransportMode mode,
                                 const InnerDensities* densities) {
    const BxDFContext context{mode, Lobes::BothSides, nullptr, false};
    SampledSpectrum value(1);
    Vec3 from = path.wi;  // back to where the light comes from
    for (int k = 0; k < path.numEvents; ++k) {
        const bool isLast = k + 1 == path.numEvents;
        const Vec3 to = isLast ? path.wo : inner[size_t(k)];
        if (!isLast && !(to.z * path.signs[size_t(k)] > 0)) return SampledSpectrum(0);
        value *= path.events[size_t(k)].interface->Evaluate(to, from, context).f;
        if (!value) return value;
        if (!isLast) {
            const float cosine = std::abs(to.z);
            value *= path.slabs[size_t(k)]->Cross(to, 1).transmittance *
                     (densities ? cosine / (*densities)[size_t(k)] : cosine);
        }
        from = -to;
    }
    return value;
}

}  // namespace lacquer::layered
