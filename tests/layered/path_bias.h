// Are estimates of a stack's shortest path right on average? Compared with the walks of ConnectionWalk, cut
// after as many vertices.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "layered/connection_walk.h"
#include "layered/paths/interface_path.h"
#include "layered/stack_cases.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::layered::test {

/// A stack and an interface sequence through it.
struct PathCase {
    std::string name;
    std::vector<Layer> layers;
    bool transmits = false, isFromBelow = false;  ///< wo's side
    TransportMode mode = TransportMode::Radiance;

    Stack Build(Arena& arena) const {
        StackCase row;
        row.layers = layers;
        return row.Build(arena);
    }
};

struct DirectionPair {
    Vec3 wo, wi;
};

/// Follows light that arrives along wo through the path. False if it ends, or leaves with a cosine of
/// leastCosine or less at any interface.
inline bool FollowLight(const PathCase& row, const Stack& stack, int numEvents, Vec3 wo, float leastCosine,
                        Rng& rng, Vec3* wi) {
    Vec3 w = wo;
    int at = stack.OuterTowards(wo);
    for (int k = 0; k < numEvents; ++k) {
        const bool reflects = !row.transmits && k == 1;
        const BxDFContext context{row.mode, reflects ? Lobes::Reflection : Lobes::Transmission, &rng};
        const auto sample = stack.interfaces[size_t(at)].Sample(w, context);
        if (!sample || !(std::abs(sample->wi.z) > leastCosine)) return false;
        *wi = sample->wi;
        w = -*wi;
        at += wi->z < 0 ? 1 : -1;
    }
    return true;
}

/// Three quarters of the pairs follow light through the path, so that they lie in its lobes; the others are
/// independent.
inline std::vector<DirectionPair> PairsOf(const PathCase& row, const Stack& stack, int count, Rng& rng) {
    const float side = row.isFromBelow ? -1.f : 1.f;
    const int numEvents = row.transmits ? stack.Last() + 1 : 3;
    std::vector<DirectionPair> pairs;
    while (int(pairs.size()) < count) {
        const Vec3 wo = side * SampleCosineHemisphere(rng.Uniform2D());
        Vec3 wi = (row.transmits ? -side : side) * SampleCosineHemisphere(rng.Uniform2D());
        bool isValid = wo.z != 0 && wi.z != 0;
        if (isValid && pairs.size() % 4 != 3)
            isValid = FollowLight(row, stack, numEvents, wo, 0.02f, rng, &wi);
        if (isValid) pairs.push_back({wo, wi});
    }
    return pairs;
}

/// Pairs whose wo is between 80 and 89.5 degrees, and whose wi is where light went that was followed through
/// the path: every other one is then moved sideways, by up to twice the radius of the hemisphere's projection
/// times a number that is mostly small, so that all distances from the lobe are among them.
inline std::vector<DirectionPair> GrazingPairsOf(const PathCase& row, const Stack& stack, int count,
                                                 Rng& rng) {
    const float side = row.isFromBelow ? -1.f : 1.f, sideOfWi = row.transmits ? -side : side;
    const int numEvents = row.transmits ? stack.Last() + 1 : 3;
    std::vector<DirectionPair> pairs;
    while (int(pairs.size()) < count) {
        const float theta = Radians(Lerp(rng.Uniform(), 80.f, 89.5f));
        const Vec3 wo = SphericalDirection(std::sin(theta), side * std::cos(theta), 2 * Pi * rng.Uniform());
        Vec3 wi;
        // All light may be reflected at such angles.
        if (!FollowLight(row, stack, numEvents, wo, 0.0087f, rng, &wi)) continue;
        if (pairs.size() % 2) {
            const float phi = 2 * Pi * rng.Uniform(), distance = 2 * Sqr(rng.Uniform());
            const float x = wi.x + distance * std::cos(phi), y = wi.y + distance * std::sin(phi);
            if (x * x + y * y > 0.9999f) continue;
            wi = {x, y, sideOfWi * SafeSqrt(1 - x * x - y * y)};
        }
        pairs.push_back({wo, wi});
    }
    return pairs;
}

/// The integral of a path of two events over its inner direction, by points on a grid of the projected
/// hemisphere. 0 if grids of two sizes differ by more than 0.2 %: lobes are too narrow for them.
inline double QuadratureOfTwoEvents(const InterfacePath& path, TransportMode mode) {
    const auto sum = [&](int side) {
        double total = 0;
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i) {
                const float x = 2 * (float(i) + 0.5f) / float(side) - 1,
                            y = 2 * (float(j) + 0.5f) / float(side) - 1;
                const float z2 = 1 - x * x - y * y;
                if (!(z2 > 0)) continue;
                const float z = std::sqrt(z2);
                const InnerDirections inner{Vec3{x, y, path.signs[0] * z}};
                total += double(PathContribution(path, inner, mode).Average() / z);
            }
        return total * 4 / Sqr(double(side));
    };
    const double coarse = sum(350), fine = sum(700);
    return std::abs(coarse - fine) > 0.002 * fine ? 0 : fine;
}

using PathEstimate = std::function<SampledSpectrum(const InterfacePath&, const BxDFContext&)>;

/// What a comparison found. Differences are relative to the mean plus the deviation of a walk between the
/// same directions, from walks of their own: so no pair of directions outweighs the others.
struct PathBias {
    RunningMean difference, walks;
    /// The estimates' excess over the walks, and its standard error.
    double Relative() const { return difference.Mean() / walks.Mean(); }
    double RelativeError() const { return difference.StandardError() / walks.Mean(); }
};

using PairsFunction = std::vector<DirectionPair> (*)(const PathCase&, const Stack&, int count, Rng&);

/// @param noisiest  walks of a larger relative deviation tell nothing: paths of two events are compared with
///                  quadrature then, others are left out
inline PathBias CompareWithWalks(const PathCase& row, const PathEstimate& estimate, int numSamples,
                                 uint64_t seed, PairsFunction pairsOf = PairsOf, double noisiest = 5) {
    constexpr int kPairs = 24, kPilots = 512;
    constexpr double kDark = 1e-4;  // [1/sr] the middle of a lobe has 0.1 to 100
    Arena arena;
    const Stack stack = row.Build(arena);
    const int numEvents = row.transmits ? stack.Last() + 1 : 3;
    Rng rng(seed);
    const BxDFContext context{row.mode, Lobes::BothSides, &rng, false};
    PathBias bias;
    int numSkipped = 0;  // there was nothing to compare with
    for (const DirectionPair& pair : pairsOf(row, stack, kPairs, rng)) {
        InterfacePath path;
        if (!FindShortestPath(stack, pair.wo, pair.wi, numEvents, &path)) {
            ADD_FAILURE() << row.name << " has no path";
            return bias;
        }
        const auto walk = [&] {
            ConnectionWalk<WalkPolicy> connections(stack, context, numEvents);
            return double(connections.Estimate(pair.wo, pair.wi).Average());
        };
        RunningMean pilot;
        for (int i = 0; i < kPilots; ++i) pilot.Add(walk());
        const double deviation = std::sqrt(pilot.Variance());
        double scale = pilot.Mean() + deviation, known = 0;
        const bool isNoisy = !(scale > 0) || deviation > noisiest * pilot.Mean();
        if (isNoisy && numEvents == 2) {
            known = QuadratureOfTwoEvents(path, row.mode);
            if (known < kDark) known = 0;
            RunningMean own;
            for (int i = 0; i < kPilots; ++i) own.Add(double(estimate(path, context).Average()));
            scale = known + std::sqrt(own.Variance());
        }
        if (isNoisy && !(known > 0)) {
            ++numSkipped;
            continue;
        }
        for (int i = 0; i < numSamples / kPairs; ++i) {
            const double value = (known > 0 ? known : walk()) / scale;
            bias.walks.Add(value);
            bias.difference.Add(double(estimate(path, context).Average()) / scale - value);
        }
    }
    EXPECT_LE(2 * numSkipped, kPairs) << row.name;
    return bias;
}

/// The same, but a deviation of more than three standard errors must show itself again, with new random
/// numbers and 16 times as many: then only the second run counts. Where light is found by rare bright
/// estimates, a few of them make a mean and its error too small together.
inline PathBias JudgeByWalks(const PathCase& row, const PathEstimate& estimate, int numSamples, uint64_t seed,
                             PairsFunction pairsOf = PairsOf, double noisiest = 5) {
    const PathBias first = CompareWithWalks(row, estimate, numSamples, seed, pairsOf, noisiest);
    if (std::abs(first.Relative()) < 3 * first.RelativeError()) return first;
    return CompareWithWalks(row, estimate, 16 * numSamples, Hash(seed), pairsOf, noisiest);
}

/// The z test of a comparison.
inline Outcome BiasOutcome(const PathCase& row, const PathBias& bias) {
    return ZTest(bias.difference, 0, 0, row.name);
}

}  // namespace lacquer::layered::test
