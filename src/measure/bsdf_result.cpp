// Whether estimators agree with samples, all of them taken together.
#include "measure/bsdf_result.h"

#include <cmath>

#include "pbrt/core/multiple_tests.h"

namespace lacquer::measure {

namespace {

constexpr double kLevel = 0.05;

/// Degrees of freedom of a difference of two means [Welch 1947].
double WelchDegreesOfFreedom(const ColorMean& a, const ColorMean& b) {
    const double va = Sqr(a.LuminanceError()), vb = Sqr(b.LuminanceError());
    const double below = (a.Count() > 1 ? Sqr(va) / double(a.Count() - 1) : 0) +
                         (b.Count() > 1 ? Sqr(vb) / double(b.Count() - 1) : 0);
    return below > 0 ? Sqr(va + vb) / below : std::numeric_limits<double>::infinity();
}

}  // namespace

Interval Agreement(const ColorMean& a, const ColorMean& b, size_t numComparisons) {
    const double error = std::hypot(a.LuminanceError(), b.LuminanceError());
    return {a.Luminance() - b.Luminance(),
            error * SidakCritical(kLevel, numComparisons, WelchDegreesOfFreedom(a, b))};
}

size_t NumAgreements(const BsdfResult& result) {
    return result.estimators.size() * (result.transmits ? 2 : 1);
}

std::vector<EnergyAgreement> AgreementsWithSamples(const BsdfResult& result) {
    const size_t numComparisons = NumAgreements(result);
    const SampledLobe& samples = result.sampled;
    std::vector<EnergyAgreement> agreements;
    for (const EstimatorResult& e : result.estimators)
        agreements.push_back({Agreement(e.energy.reflected, samples.smoothReflected, numComparisons),
                              Agreement(e.energy.transmitted, samples.smoothTransmitted, numComparisons)});
    return agreements;
}

}  // namespace lacquer::measure
