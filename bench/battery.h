// Two estimators on many random stacks and pairs of directions, each query by itself: where does one lose,
// and how often?
#pragma once

#include "comparison.h"
#include "layered/random_queries.h"

namespace lacquer::bench {

struct BatteryOptions {
    int numQueries = 1000;
    bool isTurned = false;  ///< of MakeRandomQuery()
    double seconds = 0.04;  ///< of each estimator on each query in the first round; a later one takes longer
    uint64_t seed = 1;      ///< of the queries and of all random numbers
    /// Standard deviations [1/sr] are taken for at least this: what no image shows is no noise.
    double floor = 1e-4;
    int numWorst = 10;      ///< queries to print
    int numReplicas = 200;  ///< of the bootstrap
};

/// Efficiency, 1 / (variance * CPU time), of a candidate over that of a baseline on one query.
struct EfficiencyRatio {
    double value = 1;
    double variance = 1, time = 1;  ///< its factors: quotients of the baseline's over the candidate's
    double noise = 0;               ///< standard error of log(value), by bootstrap
    bool hasSameEstimates = false;  ///< the candidate does what the baseline does
};
/// Both estimators get the same random numbers, so that a candidate that leaves a query to the baseline has
/// its very variance. They take turns, in an order that alternates; the quotient of the times is the median
/// over all turns.
/// @param round  random numbers of different rounds are independent
EfficiencyRatio MeasureEfficiency(const layered::test::RandomQuery& query, uint64_t seed, uint64_t round,
                                  double seconds, const Candidate& baseline, const Candidate& candidate,
                                  const BatteryOptions& options);

/// Prints the distribution of the ratio with intervals, and the worst queries.
///
/// The lowest of many noisy ratios are low by chance, too. So the lowest fifth is measured again with new
/// random numbers, and the lowest twentieth once more, longer each time, and what is reported of a query is
/// its last measurement alone: a choice by the earlier ones does not bias it.
void RunBattery(const Candidate& baseline, const Candidate& candidate, const BatteryOptions& options);

}  // namespace lacquer::bench
