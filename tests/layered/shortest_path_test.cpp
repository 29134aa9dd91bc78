// The shortest path in extreme geometry: each method must know where it applies.
#include "layered/paths/half_vectors/shortest_path.h"

#include <gtest/gtest.h>

#include "layered/paths/half_vectors/one_sample.h"
#include "layered/stack_cases.h"
#include "support/statistics.h"

namespace lacquer::layered::test::shortest_path_test {

using namespace lacquer::test;

namespace {

struct Row {
    const char* name;
    std::vector<Layer> layers;
    Vec3 wo, wi;
};
std::vector<Row> Rows() {
    return {
        // Facets so far from the mode that exponents have no digits left: once 41 times too bright.
        {"ggx_far_from_the_mode",
         {Dielectric(0.0963547f, 0.7147f), Dielectric(0.00763577f, 1.3561f)},
         {0.9992f, 0, 0.0405f},
         {-0.7007f, -0.2113f, -0.6815f}},
        // A middle boundary that hardly bends light: nearly all of it was lost once.
        {"anisotropic_middle_of_nearly_equal_indices",
         {Dielectric(0.00548217f, 0.7765f, kBeckmann),
          Dielectric(Alphas(0.106669f, 0.0132413f), 1.0443f, kBeckmann),
          Dielectric(0.161313f, 0.5765f, kBeckmann)},
         {-0.5012f, 0.8550f, -0.1333f},
         {0.2334f, -0.4960f, 0.8364f}},
        {"middle_of_equal_indices",
         {Dielectric(0.3f, 1.3f, kBeckmann), Dielectric(0.1f, 1.0001f, kBeckmann),
          Dielectric(0.1f, 0.8f, kBeckmann)},
         {0.4663f, 0.4327f, 0.7716f},
         {-0.41f, -0.4f, -0.8f}},
    };
}

// Against draws of plain walks. Power: a factor of 1.2 in the worst case, whose noise is 6 times its mean.
TEST(ShortestPath, HasTheMeanOfWalksWhereMethodsEnd) {
    constexpr int kSamples = 100000;
    for (const Row& row : Rows()) {
        Arena arena;
        const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
        Rng rng(SeedOf(FullTestName() + row.name));
        const BxDFContext context{.rng = &rng, .needsPdf = false};
        InterfacePath path;
        ASSERT_TRUE(FindShortestPath(stack, Normalize(row.wo), Normalize(row.wi), 3, &path)) << row.name;
        const ShortestPathMethod method = ShortestPathMethodFor(path);
        RunningMean shortest, walks;
        for (int i = 0; i < kSamples; ++i) {
            shortest.Add(double(EstimateShortestPath(method, path, context).Average()));
            walks.Add(double(EstimateByOneSample(path, context).Average()));
        }
        EXPECT_NEAR(shortest.Mean(), walks.Mean(),
                    4.5 * std::hypot(shortest.StandardError(), walks.StandardError()))
            << row.name;
        EXPECT_LT(shortest.StandardError(), 0.03 * shortest.Mean()) << row.name;
    }
}

}  // namespace
}  // namespace lacquer::layered::test::shortest_path_test
