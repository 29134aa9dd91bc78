// How far single estimates lie from the mean, between directions up to the horizon and off the lobes. Knows
// no test framework: a benchmark prints the same figures.
#pragma once

#include "layered/estimator.h"
#include "layered/stack_cases.h"

namespace lacquer::layered::test {

/// Stacks of two and three rough interfaces beside those of StackCases(): smooth over rough and the other way
/// round, both distributions, all that product estimators take apart from others.
const std::vector<StackCase>& ProductStackCases();

/// Outer directions, named by their angles: "89 20 90" has wo at 89 degrees, wi at 20, turned by 90 degrees
/// from the azimuth of the mirror's direction; "... below" has wi below the stack, where light passes.
struct TailQuery {
    std::string name;
    Vec3 wo, wi;
};
/// From 20 to 89.5 degrees: in the lobes, next to them, and far off.
std::vector<TailQuery> TailQueriesOf(const Stack& stack);

/// What a number of estimates looked like. Averages over the wavelengths.
struct Tail {
    double mean = 0;       ///< [1/sr]
    double deviation = 0;  ///< standard deviation over the mean; 0 where the mean is
    double largest = 0;    ///< the largest estimate over the mean; 0 where the mean is
};
/// Power: a value that comes with probability p is among the estimates with probability 1 - (1 - p)^n.
Tail MeasureTail(const LayeredEstimator& estimator, const Stack& stack, const TailQuery& query,
                 int maxVertices, int numEstimates, uint64_t seed);

}  // namespace lacquer::layered::test
