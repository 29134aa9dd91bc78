#include "layered/chains/lead.h"

#include "layered/chains/half_vector.h"
#include "layered/chains/one_sample.h"
#include "layered/chains/scale_mixture.h"
#include "pbrt/core/check.h"

namespace lacquer {

LeadMethod LeadMethodFor(const Chain& chain) {
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

}  // namespace lacquer
