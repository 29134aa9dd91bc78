// Several statistical tests at once: what a family of them finds although nothing is there.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

namespace lacquer {

/// Probability that a standard normal number is further from 0 than z. NaN of NaN.
inline double TwoSidedNormalP(double z) { return std::erfc(std::abs(z) / 1.4142135623730951); }

/// Probability that the least of `numTests` p-values is at most p although no test has anything to find:
/// 1 - (1 - p)^n [Sidak 1967]. Exact for independent tests, an upper bound for two-sided tests of jointly
/// normal numbers however they are correlated, such as differences from one common mean.
inline double SidakP(double p, size_t numTests) { return -std::expm1(double(numTests) * std::log1p(-p)); }

/// |t| that any of `numTests` two-sided tests exceeds with a probability of `level` at most. @param
/// degreesOfFreedom  of Student's t, infinite for a normal number; 30 or more for an error of t below 1e-3
/// [Abramowitz and Stegun 1964] 26.7.5.
double SidakCritical(double level, size_t numTests,
                     double degreesOfFreedom = std::numeric_limits<double>::infinity());

}  // namespace lacquer
