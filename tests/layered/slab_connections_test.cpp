// Connections of eight vertices at once are those of one after the other.
//
// They draw no random numbers, so both ways follow the same walks and find the same light, estimate by
// estimate: what differs is rounding, mostly the order of sums of terms that are not negative. A wrong weight
// or a lost term of a per mille of a value is found.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "layered/connection_walk.h"
#include "layered/stack_cases.h"

namespace lacquer::layered::test::slab_connections_test {

namespace {

struct OneByOne : WalkPolicy {
    static constexpr bool kConnectsInLanes = false;
};

/// Degrees, the azimuth between the two; from the surface's normal to its horizon and below.
struct Angles {
    float thetaODeg, thetaIDeg, phiDeg;
};
constexpr Angles kAngles[] = {{0, 0, 0},      {30, 45, 180}, {60, 20, 90},   {89.5f, 89.5f, 180},
                              {10, 89.5f, 0}, {85, 40, 130}, {30, 150, 180}, {91, 20, 30}};
constexpr int kNumEstimates = 16;
/// Of a value: a sum of up to 1,000 terms, each of some ten roundings.
constexpr double kTolerance = 1e-4;

Vec3 Direction(float thetaDeg, float phiDeg) {
    return SphericalDirection(std::sin(Radians(thetaDeg)), std::cos(Radians(thetaDeg)), Radians(phiDeg));
}

template <class Policy>
SampledSpectrum Estimate(const Stack& stack, const Angles& a, uint64_t seed, int maxVertices,
                         KnownPaths excluded = {}) {
    Rng rng(Hash(seed));
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    return ConnectionWalk<Policy>(stack, context, maxVertices, excluded)
        .Estimate(Direction(a.thetaODeg, 0), Direction(a.thetaIDeg, a.phiDeg));
}

/// The largest difference of two ways, relative to a value, over all angles and estimates.
struct Difference {
    double largest = 0;
    int positive = 0;  ///< values that are not 0
};
Difference Compare(const Stack& inLanes, const Stack& oneByOne, int maxVertices, KnownPaths excluded = {}) {
    Difference difference;
    uint64_t seed = 0;
    for (const Angles& a : kAngles)
        for (int i = 0; i < kNumEstimates; ++i) {
            const SampledSpectrum x = Estimate<WalkPolicy>(inLanes, a, ++seed, maxVertices, excluded),
                                  y = Estimate<OneByOne>(oneByOne, a, seed, maxVertices, excluded);
            EXPECT_TRUE(x.IsValid());
            for (int c = 0; c < kNumWavelengths; ++c) {
                const double larger = double(std::max(x[c], y[c]));
                // Below this, floats have fewer digits.
                if (!(larger > 1e-30)) continue;
                ++difference.positive;
                difference.largest =
                    std::max(difference.largest, std::abs(double(x[c]) - double(y[c])) / larger);
            }
        }
    return difference;
}

bool HasLanes(const Stack& stack) {
    for (const Slab& slab : stack.slabs)
        if (SlabConnections::Knows(slab)) return true;
    return false;
}

/// Stacks where walks take many lanes, leave them partly empty, and pass from one slab into another.
std::vector<StackCase> ExtraCases() {
    const SampledSpectrum coloured = Lanes(0.3f, 1, 2.5f, 6), albedo = Lanes(0.4f, 0.9f, 0.99f, 1);
    return {
        {.name = "white", .layers = {Dielectric(0.3f, 1.5f), Medium(20, 1, HG(0.5f)), Diffuse(1)}},
        {.name = "coloured",
         .layers = {Dielectric(0.1f, 1.5f), Medium(coloured, albedo, HG(0.9f)), Metal(0.1f)}},
        {.name = "backward",
         .layers = {Dielectric(0, 1.5f), Medium(3, 0.9f, HG(-0.7f)), Dielectric(0.2f, 0.8f)}},
        {.name = "two slabs",
         .layers = {Dielectric(0.2f, 1.3f), Medium(coloured, albedo, HG(0.3f)), Nothing(), Absorber(0.1f),
                    Dielectric(0.1f, 1.2f), Medium(2, 0.95f, HG(-0.2f)), Diffuse(0.8f)}},
        {.name = "two kinds of slabs",
         .layers = {Dielectric(0.2f, 1.3f), Medium(2, 0.9f, HG(0.3f)), Nothing(), Medium(2, 0.9f, Rainbow()),
                    Metal(0)}},
        {.name = "needle", .layers = {Nothing(), Medium(5, 1, HG(0.9999f)), Diffuse(1)}},
    };
}

}  // namespace

TEST(SlabConnections, AreThoseOfOneVertexAfterTheOther) {
    std::vector<StackCase> cases = ExtraCases();
    cases.insert(cases.end(), StackCases().begin(), StackCases().end());
    int numStacks = 0;
    for (const StackCase& row : cases) {
        Arena arena;
        const Stack stack = row.Build(arena);
        if (!HasLanes(stack)) continue;
        ++numStacks;
        for (const int maxVertices : {2, 3, 7, 12, kMaxPathVertices}) {
            const Difference d = Compare(stack, stack, maxVertices);
            EXPECT_LT(d.largest, kTolerance) << row.name << ", " << maxVertices << " vertices";
            EXPECT_TRUE(d.positive > 0 || maxVertices < kMaxPathVertices) << row.name;
        }
        EXPECT_LT(Compare(stack, stack, kMaxPathVertices, {3, 5}).largest, kTolerance) << row.name;
    }
    EXPECT_GE(numStacks, 20);
}

// What is joined eight at a time is rounded otherwise: the same bits would tell that nothing was.
TEST(SlabConnections, JoinVerticesInSlabsEightAtATime) {
    for (const StackCase& row : ExtraCases()) {
        Arena arena;
        const Stack stack = row.Build(arena);
        EXPECT_GT(Compare(stack, stack, kMaxPathVertices).largest, 0) << row.name;
    }
}

TEST(SlabConnections, NegativeControlOneThousandthMoreScatteringIsFound) {
    const auto stack = [](Arena& arena, float albedo) {
        return StackCase{.name = "",
                         .layers = {Dielectric(0.1f, 1.5f), Medium(2, albedo, HG(0.5f)), Metal(0.1f)}}
            .Build(arena);
    };
    Arena arena;
    EXPECT_GT(Compare(stack(arena, 0.9f), stack(arena, 0.9009f), kMaxPathVertices).largest, 5 * kTolerance);
}

}  // namespace lacquer::layered::test::slab_connections_test
