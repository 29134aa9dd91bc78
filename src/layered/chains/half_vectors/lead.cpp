#include "layered/chains/half_vectors/lead.h"

#include "layered/chains/half_vectors/half_vector.h"
#include "layered/chains/half_vectors/one_sample.h"
#include "layered/chains/mixtures/scale_mixture.h"
#include "pbrt/core/check.h"

namespace lacquer::layered {
namespace {

/// True if all boundaries bend the light that they let through. Facets between nearly equal indices hardly
/// do, whatever their slopes, which are then no coordinates for directions. In the middle of a chain this
/// starts early: there the slope is a result of those at the ends.
bool BendsLight(const Chain& chain) {
    constexpr float kLeastAtEnds = 0.02f, kLeastPerAlpha = 0.55f;
    float roughest = 0;
    for (int k = 0; k < chain.numEvents; ++k) {
        const ChainEvent& event = chain.events[size_t(k)];
        roughest = std::max({roughest, event.surface.alphaX, event.surface.alphaY});
        if (event.transmits && std::abs(std::log(event.eta)) < kLeastAtEnds) return false;
    }
    const ChainEvent& middle = chain.events[1];
    if (chain.numEvents < 3 || !middle.transmits) return true;
    return std::abs(std::log(middle.eta)) > kLeastPerAlpha * roughest;
}

}  // namespace

LeadMethod LeadMethodFor(const Chain& chain) {
    if (!BendsLight(chain)) return LeadMethod::OneSample;
    if (HalfVectorApplies(chain)) return LeadMethod::HalfVector;
    if (!ScaleMixtureApplies(chain)) return LeadMethod::None;
    return ScaleMixturePays(chain) ? LeadMethod::ScaleMixture : LeadMethod::OneSample;
}

SampledSpectrum EstimateLead(LeadMethod method, const Chain& chain, const BxDFContext& context) {
    switch (method) {
        case LeadMethod::HalfVector:
            return EstimateHalfVectorChain(chain, *context.rng, context.mode);
        case LeadMethod::ScaleMixture:
            return EstimateByScaleMixture(chain, context);
        case LeadMethod::OneSample:
            return EstimateByOneSample(chain, context);
        case LeadMethod::None:
            break;
    }
    LACQUER_CHECK(false);
    return SampledSpectrum(0);
}

}  // namespace lacquer::layered
