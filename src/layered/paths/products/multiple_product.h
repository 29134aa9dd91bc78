// Multiple products: all inner directions of a path, drawn from one density that approximates the product of
// all its lobes [Xia et al. 2020, sec. 4.4 and 5.3], for paths of any length.
//
// The paper makes the middle lobe of three a Gaussian over both of its directions, by a second-order
// expansion of its exponent (app. B). Here the path is a Markov chain in slopes, with Gaussian steps whose
// mean is not linear, and it is treated as such:
//  1. Messages. The lobe of an outer direction is a Gaussian over the first inner one. An event turns a
//     Gaussian over the direction before it into one over the direction behind it: the lobe seen from the
//     mean, its mean made linear there, wider by what the direction before may vary. So a message sums all
//     events between its direction and the end where it started (the block elimination of the joint Gaussian,
//     whose precision is block-tridiagonal; also known as the extended Kalman filter).
//  2. Draws. One direction is drawn from the product of the messages that reach it, then each neighbour from
//     its message times the lobe of the event between them, seen from the direction just drawn. That lobe is
//     looked up anew, so nothing of it is linear.
// Where lobes are mixtures, so are messages and products: one part for each pair of parts. No part is ever
// chosen for the whole path: each draw is from the mixture over all, given the direction drawn before it.
// The density is the product of those of the draws. It is positive wherever the integrand is, and no matrix
// needs repair. With three events the noise is 0.85 to 1 of that of a Gaussian over both directions, and
// tails are light even where the end's lobe is much wider than the middle one's.
#pragma once

#include "gaussfit/lobe/lobe.h"
#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// Draws a path's inner directions and estimates its integral. Small; refers to the path.
/// @tparam kParts  Gaussians that a lobe has at most: 1 for Beckmann's facets, 2 for all
template <int kParts>
class MultipleProductOf {
  public:
    /// False if an interface is anisotropic, if its lobes have more parts or are beyond the tables at a mean,
    /// if one of the outer sides is the denser one, or if light comes near total reflection inside, where all
    /// that a Gaussian knows is wrong. False for mixtures on paths of more than three events, whose tails
    /// nothing would bound. The answer depends on nothing that is drawn.
    /// Cost: a look-up for each part of each event's message, 30 ns, or 60 ns for mixtures.
    bool Set(const InterfacePath& path);
    /// An unbiased estimate of the path's integral [1/sr]. Costs a look-up for each inner event and a value
    /// of each interface.
    SampledSpectrum Estimate(TransportMode mode, Rng& rng) const;

  private:
    template <int kOther>
    bool SetProduct(const gaussfit::GaussianMixtureOf<kOther>& message,
                    const gaussfit::GaussianMixtureOf<kParts>& end);
    /// Draws the inner directions and gives their densities; without `rng` those of given directions.
    void SetDirections(Rng* rng, InnerDirections* inner, InnerDensities* densities) const;

    const InterfacePath* path_ = nullptr;
    float wideShare_ = 0, walkShare_ = 0;
    int first_ = 0;  ///< the inner direction that is drawn first
    /// Over each other one, from the end that it is towards.
    std::array<gaussfit::GaussianMixtureOf<kParts>, InterfacePath::kMaxInner> messages_;
    /// Over the first one, of both messages.
    gaussfit::GaussianMixtureOf<kParts * kParts * kParts> product_;
};
using MultipleProduct = MultipleProductOf<1>;
using MultipleProductOfMixtures = MultipleProductOf<2>;

/// True if a lobe of the path is a mixture.
inline bool HasMixtures(const InterfacePath& path) {
    bool hasMixtures = false;
    for (int k = 0; k < path.numEvents; ++k)
        hasMixtures |= path.events[size_t(k)].surface.model != MicrofacetModel::Beckmann;
    return hasMixtures;
}

/// True unless other methods take less time to equal error, as measured: pair products where a rough
/// interface turns light back, at which their walks meet; walks for paths of more than five events that
/// reflect more than once, where errors of messages add up to heavy tails.
bool MultipleProductIsWorthwhile(const InterfacePath& path);

}  // namespace lacquer::layered
