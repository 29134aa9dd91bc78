#include "layered/paths/half_vectors/shortest_path.h"

#include "layered/paths/half_vectors/half_vector.h"
#include "layered/paths/half_vectors/one_sample.h"
#include "layered/paths/mixtures/scale_mixture.h"
#include "pbrt/core/check.h"

namespace lacquer::layered {
namespace {

/// True if all boundaries bend the light that they let through. Facets between nearly equal indices hardly
/// do, whatever their slopes, which are then no coordinates for directions. In the middle of a path this
/// starts early: there the slope is a result of those at the ends.
bool RefractsLight(const InterfacePath& path) {
    constexpr float kMinAtEnds = 0.02f, kMinPerAlpha = 0.55f;
    float roughest = 0;
    for (int k = 0; k < path.numEvents; ++k) {
        const PathEvent& event = path.events[size_t(k)];
        roughest = std::max({roughest, event.surface.alphaX, event.surface.alphaY});
        if (event.transmits && std::abs(std::log(event.eta)) < kMinAtEnds) return false;
    }
    const PathEvent& middle = path.events[1];
    if (path.numEvents < 3 || !middle.transmits) return true;
    return std::abs(std::log(middle.eta)) > kMinPerAlpha * roughest;
}

/// True if the path turns where the far side is thinner. A few facets then reflect totally, hundreds of times
/// as much as the others, which only draws that know Fresnel's equations find as often as they should.
bool MayReflectTotally(const InterfacePath& path) {
    const PathEvent& middle = path.events[1];
    if (path.numEvents < 3 || middle.transmits || middle.surface.eta == 0) return false;
    const bool comesFromAbove = path.signs[0] < 0;  // surface.eta is below over above
    return comesFromAbove ? middle.surface.eta < 1 : middle.surface.eta > 1;
}
/// True if facets are spread so differently along and across that mixtures have no digits for it: sums of
/// their densities come from determinants, the difference of products.
bool HasThinnestFacets(const InterfacePath& path) {
    constexpr float kMaxQuotient = 100;
    for (int k = 0; k < path.numEvents; ++k) {
        const MicrofacetSurface& surface = path.events[size_t(k)].surface;
        const auto [least, most] = std::minmax(surface.alphaX, surface.alphaY);
        if (most > kMaxQuotient * least) return true;
    }
    return false;
}

}  // namespace

ShortestPathMethod ShortestPathMethodFor(const InterfacePath& path) {
    if (!RefractsLight(path)) return ShortestPathMethod::OneSample;
    if (HalfVectorApplies(path)) return ShortestPathMethod::HalfVector;
    // Beckmann's tails have none of these facets.
    if (MayReflectTotally(path)) return ShortestPathMethod::None;
    if (HasThinnestFacets(path)) return ShortestPathMethod::OneSample;
    return ScaleMixtureIsWorthwhile(path) ? ShortestPathMethod::ScaleMixture : ShortestPathMethod::OneSample;
}

SampledSpectrum EstimateShortestPath(ShortestPathMethod method, const InterfacePath& path,
                                     const BxDFContext& context) {
    switch (method) {
        case ShortestPathMethod::HalfVector:
            return EstimateByHalfVectors(path, context);
        case ShortestPathMethod::ScaleMixture:
            return EstimateByScaleMixture(path, context);
        case ShortestPathMethod::OneSample:
            return EstimateByOneSample(path, context);
        case ShortestPathMethod::None:
            break;
    }
    LACQUER_CHECK(false);
    return SampledSpectrum(0);
}

}  // namespace lacquer::layered
