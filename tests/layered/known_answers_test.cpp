// Albedos of stacks that others have computed: the validation stacks of [Guo et al. 2018], by volumetric path
// tracing of slabs of triangles, without any of the position-free theory.
#include <gtest/gtest.h>

#include "layered/agreement.h"

namespace lacquer::test {
namespace {

struct Known {
    const char* name;
    double red, green, blue;
};

TEST(LayeredKnownAnswers, ValidationStacksHaveTheirAlbedos) {
    const Known kKnown[] = {{"v1", 0.2128, 0.2093, 0.3281},
                            {"v2", 0.1116, 0.1398, 0.2848},
                            {"v3", 0.0534, 0.0624, 0.1928},
                            {"v4", 0.2235, 0.3348, 0.3558}};
    // Errors of the known values (0.0004), of a rounded index of copper (0.5 %), and ours.
    constexpr double kKnownError = 4e-4, kMetalError = 0.005;
    const int numWalks = IsFullRun() ? 4000000 : Scaled(150000);
    const int numValues = IsFullRun() ? 2000000 : Scaled(30000);
    const Vec3 wo{-std::sqrt(0.5f), 0, std::sqrt(0.5f)};
    for (const Known& known : kKnown) {
        Arena arena;
        const LayeredBxDF* bxdf =
            FindStackCase(known.name).MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
        const LobeQuery query{bxdf->GetStack(), wo};
        const uint64_t seed = SeedOf(known.name);
        const Moments walks = MomentsByWalks(query, numWalks, Hash(seed, 1));
        const Moments values = MomentsByValues(query, GuideOf(query, Hash(seed, 2)), numValues, Hash(seed, 3),
                                               ValuesOf(*bxdf, wo, query.mode));
        const double expected[] = {known.red, known.green, known.blue};
        for (const Moments* found : {&walks, &values})
            for (int lane = 0; lane < 3; ++lane) {
                const int moment = 2 * kWeightsPerSide + lane;
                EXPECT_NEAR(
                    found->Mean(moment), expected[lane],
                    4 * std::hypot(kKnownError, found->StandardError(moment)) + kMetalError * expected[lane])
                    << known.name << " lane " << lane << (found == &walks ? " walks" : " values");
            }
    }
}

// A clear rough coat over white-ish ground; a neutral stack, so that no colour enters.
TEST(LayeredKnownAnswers, CoatedDiffuseHasItsAlbedo) {
    Arena arena;
    const StackCase row{.name = "", .layers = {Dielectric(0.3f, 1.5f, kBeckmann), Diffuse(0.8f)}};
    const Stack stack = row.Build(arena);
    const Moments walks = MomentsByWalks({stack, Vec3(0.6f, 0, 0.8f)}, 200000, SeedOf(FullTestName()));
    EXPECT_NEAR(walks.Albedo(), 0.5913, 4 * std::hypot(4e-4, walks.AlbedoError()));
}

}  // namespace
}  // namespace lacquer::test
