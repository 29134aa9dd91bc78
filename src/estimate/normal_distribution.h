// The standard normal distribution, and one that is cut to an interval.
#pragma once

namespace lacquer::estimate {

/// Probability that a standard normal variable is below z. Relative error about 1e-15 where z < 0.
double NormalCdf(double z);
/// Its inverse for p in (0, 1), -inf at 0 and inf at 1; relative error about 1e-15 [Wichura 1988], PPND16.
double NormalQuantile(double p);

/// A normal distribution, cut to [low, high].
struct TruncatedNormal {
    double mean, sd, low, high;

    /// Probability of [low, high] under the normal distribution that was cut.
    double Mass() const;
    /// Logarithm of the density, which integrates to 1 over [low, high]; -inf outside.
    double LogDensity(double x) const;
    /// The point below which a part u in [0, 1] of the distribution lies: exact draws for uniform u. Good in
    /// the tails as well, up to 37 deviations from the mean.
    double Quantile(double u) const;
};

}  // namespace lacquer::estimate
