// One sample of a path by one of the strategies with which walks from both sides can make it. Needs no setup
// and works for all interfaces that a path may have.
#pragma once

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// A path's integrand together with the densities with which walks draw it.
struct PathTerms {
    SampledSpectrum value;  ///< PathContribution()
    /// For each event the density of the direction in which light leaves it, drawn by a walk that follows the
    /// light, and of the one from which light comes, drawn by a walk towards the light [1/sr]. Walks know
    /// whether an event transmits, so both are conditional on that.
    std::array<float, InterfacePath::kMaxEvents> forward{}, backward{};
};

/// PathContribution() and the densities. They are set up to the first event where the value is 0.
PathTerms EvaluatePathTerms(const InterfacePath& path, const InnerDirections& inner, TransportMode mode);

/// Draws the direction in which light leaves event k as a walk along the light does, the one before it being
/// given; or the one from which light comes to event k as a walk towards it does, given the one behind. False
/// if that fails. The density is that of PathTerms.
bool SampleForward(const InterfacePath& path, int k, const BxDFContext& context, InnerDirections* inner);
bool SampleBackward(const InterfacePath& path, int k, const BxDFContext& context, InnerDirections* inner);

/// Draws a path's inner directions by walks from both ends: one event is the connection, which both walks
/// reach, and which they take as it comes. The connection is drawn, rough events being the likelier ones,
/// since they are the least particular about directions. The density sums over all connections.
class OneSample {
  public:
    /// @param smallestShare  probability that each connection has at least, below 1/3. Larger ones mean more
    /// noise in the lobes and less of it far from them, where any one event may turn light by a wide angle
    explicit OneSample(const InterfacePath& path, float smallestShare = 0.001f);

    /// False if a walk fails. Takes its random numbers from context.rng.
    bool Sample(const InterfacePath& path, const BxDFContext& context, InnerDirections* inner) const;
    /// Density of Sample() [1/sr per inner direction], which integrates to the chance that it succeeds.
    float Pdf(const InterfacePath& path, const PathTerms& terms) const;
    /// An unbiased estimate of the path's integral over the inner directions: value / density of one draw,
    /// with one evaluation only, and safe from densities that leave the range of a float.
    SampledSpectrum Estimate(const InterfacePath& path, const BxDFContext& context) const;

  private:
    int SampleConnectionEvent(const InterfacePath& path, float u) const;

    std::array<float, InterfacePath::kMaxEvents> shares_{};  ///< probability of each connection
};

/// An unbiased estimate by one sample of each connection, the walks being shared, weighted by the balance
/// heuristic: what ConnectionWalk does with this path. About twice the cost of OneSample's, and less noise
/// where the connections find different parts of the integral: far off the lobe, where any one event may turn
/// the light.
SampledSpectrum EstimateByAllConnections(const InterfacePath& path, const BxDFContext& context);

/// OneSample's estimate in one step.
inline SampledSpectrum EstimateByOneSample(const InterfacePath& path, const BxDFContext& context) {
    return OneSample(path).Estimate(path, context);
}

}  // namespace lacquer::layered
