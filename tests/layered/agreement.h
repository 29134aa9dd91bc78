// The verdict on one query of one stack: do values and walks agree?
#pragma once

#include <functional>

#include "layered/lobe_moments.h"
#include "layered/stack_cases.h"

namespace lacquer::layered::test {

/// True if the environment asks for the full set (LACQUER_FULL=1): all stacks, 0.5 % of relative standard
/// error, tens of minutes. Else the fast subset.
bool IsFullRun();

/// True if it asks for all stacks at the effort of the fast subset (LACQUER_ALL_STACKS=1): a few minutes.
bool AsksForAllStacks();

/// How much work goes into one query.
struct Effort {
    int numWalks, numValues;
    /// Values are added until the albedo has this relative standard error, as far as a first run can tell...
    double wantedError;
    int maxValues;  ///< ... and not more than this
};
Effort DefaultEffort();

/// Deviations above this many standard errors are looked at again.
inline constexpr double kSuspicious = 4;

/// f(wo, wi, mode) without the cosine, by value or estimate.
using ValueFunction = std::function<SampledSpectrum(Vec3 wi, Rng& rng)>;

struct Agreement {
    Moments values, walks;
    Comparison comparison;
    double WorstZ() const { return comparison.WorstZ(); }
};

/// What walks say of a query, for all estimators that are compared with it: where light leaves, and the
/// moments.
struct WalkedQuery {
    LobeQuery query;
    GuideDensity guide;
    Moments walks;
};
WalkedQuery TakeWalks(const LobeQuery& query, int numWalks, uint64_t seed);

/// Compares values with walks. A deviation above `suspicious` standard errors must repeat itself with new
/// random numbers, walks and 16 times as many values: then only the second run counts. So rare bright values,
/// which make a mean and its error too small together, give few false alarms, and the chance of one is at
/// most that of a single run.
///
/// Power: at the fast subset's effort an error of 5 % of an albedo is found in any single query, one of 0.6 %
/// over all queries of an estimator together; at the full set's 2.5 % and 0.2 %.
/// @param walked  the stack that the walks see; the value function may see another one (controls)
Agreement Examine(const WalkedQuery& walked, const ValueFunction& f, const Effort& effort, uint64_t seed,
                  double suspicious);
/// The same with walks of its own.
Agreement Examine(const LobeQuery& walked, const ValueFunction& f, const Effort& effort, uint64_t seed,
                  double suspicious);

/// The query's directions: steep to grazing from above, and from below where light passes. The mode
/// alternates in the fast subset; the full set has both for each direction.
struct NamedQuery {
    std::string name;
    Vec3 wo;
    TransportMode mode;
};
std::vector<NamedQuery> QueriesOf(const Stack& stack);

/// Values of a stack by an estimator, with the exact part.
ValueFunction ValuesOf(const BxDF& bxdf, Vec3 wo, TransportMode mode);

}  // namespace lacquer::layered::test
