// One sample of a chain by one of the ways in which walks from both sides can make it. Needs no setup and
// works for all interfaces that a chain may have.
#pragma once

#include "layered/chains/chain.h"

namespace lacquer::layered {

/// A chain's integrand together with the densities with which walks draw it.
struct ChainTerms {
    SampledSpectrum value;  ///< ChainValue()
    /// For each event the density of the direction in which light leaves it, drawn by a walk that follows the
    /// light, and of the one from which light comes, drawn by a walk towards the light [1/sr]. Walks know
    /// whether an event transmits, so both are conditional on that.
    std::array<float, Chain::kMaxEvents> forward{}, backward{};
};

/// ChainValue() and the densities. They are set up to the first event where the value is 0.
ChainTerms EvaluateChain(const Chain& chain, const ChainDirections& inner, TransportMode mode);

/// Draws the first inner direction as a walk along the light does, or the last one as a walk towards it does.
/// False if that fails. The density is that of ChainTerms.
bool DrawForward(const Chain& chain, const BxDFContext& context, ChainDirections* inner);
bool DrawBackward(const Chain& chain, const BxDFContext& context, ChainDirections* inner);

/// Draws a chain's inner directions by walks from both ends: one event is the meeting, which both walks
/// reach, and which they take as it comes. The meeting is drawn, rough events being the likelier ones, since
/// they are the least particular about directions. The density sums over all meetings.
class OneSample {
  public:
    /// @param smallestShare  probability that each meeting has at least, below 1/3. Larger ones mean more
    /// noise in the lobes and less of it far from them, where any one event may turn light by a wide angle
    explicit OneSample(const Chain& chain, float smallestShare = 0.001f);

    /// False if a walk fails. Takes its random numbers from context.rng.
    bool Draw(const Chain& chain, const BxDFContext& context, ChainDirections* inner) const;
    /// Density of Draw() [1/sr per inner direction], which integrates to the chance that it succeeds.
    float Pdf(const Chain& chain, const ChainTerms& terms) const;
    /// An unbiased estimate of the chain's integral over the inner directions: value / density of one draw,
    /// with one evaluation only, and safe from densities that leave the range of a float.
    SampledSpectrum Estimate(const Chain& chain, const BxDFContext& context) const;

  private:
    int DrawMeeting(const Chain& chain, float u) const;

    std::array<float, Chain::kMaxEvents> shares_{};  ///< probability of each meeting
};

/// The same in one step.
inline SampledSpectrum EstimateByOneSample(const Chain& chain, const BxDFContext& context) {
    return OneSample(chain).Estimate(chain, context);
}

}  // namespace lacquer::layered
