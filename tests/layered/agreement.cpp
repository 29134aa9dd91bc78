#include "layered/agreement.h"

#include <cmath>
#include <cstdlib>

#include "pbrt/core/sampling.h"

namespace lacquer::layered::test {

namespace {

bool IsSet(const char* variable) {
    const char* value = std::getenv(variable);
    return value && *value && *value != '0';
}

}  // namespace

bool IsFullRun() { return IsSet("LACQUER_FULL"); }
bool AsksForAllStacks() { return IsFullRun() || IsSet("LACQUER_ALL_STACKS"); }

Effort DefaultEffort() {
    if (IsFullRun()) return {400000, 20000, 0.004, 1 << 26};
    return {Scaled(30000), Scaled(10000), 1, Scaled(10000)};
}

WalkedQuery TakeWalks(const LobeQuery& query, int numWalks, uint64_t seed) {
    return {query, GuideOf(query, Hash(seed, 0)), MomentsByWalks(query, numWalks, Hash(seed, 0, 2))};
}

Agreement Examine(const LobeQuery& walked, const ValueFunction& f, const Effort& effort, uint64_t seed,
                  double suspicious) {
    return Examine(TakeWalks(walked, effort.numWalks, seed), f, effort, seed, suspicious);
}

Agreement Examine(const WalkedQuery& walked, const ValueFunction& f, const Effort& effort, uint64_t seed,
                  double suspicious) {
    const auto run = [&](int numWalks, int numValues, int round) {
        const Moments values =
            MomentsByValues(walked.query, walked.guide, numValues, Hash(seed, round, 1), f);
        const Moments walks =
            round == 0 ? walked.walks : MomentsByWalks(walked.query, numWalks, Hash(seed, round, 2));
        return Agreement{values, walks, Compare(values, walks)};
    };
    // A run tells how many values the next one needs. Its own values do not count then: whether it was lucky
    // decides how long the next one is.
    const int numWalks = effort.numWalks;
    int numValues = effort.numValues;
    Agreement agreement = run(numWalks, numValues, 0);
    for (int round = 1; round <= 3 && numValues < effort.maxValues; ++round) {
        const double albedo = agreement.values.Albedo(), error = agreement.values.AlbedoError();
        constexpr double kSlack = 1.2;
        if (error <= kSlack * effort.wantedError * albedo) break;
        const double factor = error / (effort.wantedError * std::max(albedo, 1e-9));
        numValues = int(std::min(double(effort.maxValues), factor * factor * double(numValues)));
        agreement = run(numWalks, numValues, round);
    }
    if (!(agreement.WorstZ() < suspicious))
        agreement =
            run(std::min(4 * numWalks, 1 << 22), int(std::min(16 * int64_t(numValues), int64_t(1) << 24)), 4);
    return agreement;
}

std::vector<NamedQuery> QueriesOf(const Stack& stack) {
    const auto at = [](float deg, float phi) {
        return SphericalDirection(std::sin(Radians(deg)), std::cos(Radians(deg)), phi);
    };
    std::vector<NamedQuery> queries = {{"20deg", at(20, 0.5f), TransportMode::Radiance},
                                       {"60deg", at(60, 2), TransportMode::Importance},
                                       {"86deg", at(86, 4), TransportMode::Radiance}};
    if (Transmits(stack)) {
        queries.push_back({"below", at(130, 1), TransportMode::Radiance});
        queries.push_back({"below_grazing", at(96, 3), TransportMode::Importance});
    }
    if (IsFullRun())
        for (size_t i = queries.size(); i-- > 0;)
            queries.push_back({queries[i].name + " adjoint", queries[i].wo, !queries[i].mode});
    return queries;
}

ValueFunction ValuesOf(const BxDF& bxdf, Vec3 wo, TransportMode mode) {
    return [&bxdf, wo, mode](Vec3 wi, Rng& rng) {
        return bxdf.Evaluate(wo, wi, {mode, Lobes::BothSides, &rng, false}).f;
    };
}

}  // namespace lacquer::layered::test
