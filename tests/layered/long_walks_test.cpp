// Light that goes through many smooth interfaces, or scatters in a thin slab between them, is not lost: the
// walks of ConnectionWalk are then long, and most of the light is made by strategies that other stacks hardly
// need.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <mutex>

#include "layered/agreement.h"
#include "layered/estimators/walk_estimator.h"
#include "pbrt/core/parallel.h"

namespace lacquer::layered::test::long_walks_test {

namespace {

const Vec3 kOblique = SphericalDirection(std::sin(Radians(40)), std::cos(Radians(40)), 1.1f);

struct LongWalkCase {
    std::string name;
    std::vector<Layer> layers;
    int numWalks;  ///< of the analog walk, for an error of 1 % and less
    int numValues;
};

/// `count` interfaces that are not there between others.
std::vector<Layer> WithNothings(const Layer& first, int count, const std::vector<Layer>& last) {
    std::vector<Layer> layers{first};
    layers.insert(layers.end(), size_t(count), Nothing());
    layers.insert(layers.end(), last.begin(), last.end());
    return layers;
}

const std::vector<LongWalkCase>& LongWalkCases() {
    static const std::vector<LongWalkCase> cases = {
        {"thirty_nothings_over_white", WithNothings(Dielectric(0, 1.5f), 30, {Diffuse(1)}), 20000, 20000},
        {"sixty_nothings_over_white", WithNothings(Dielectric(0, 1.5f), 62, {Diffuse(1)}), 20000, 20000},
        {"sixty_nothings_over_medium",
         WithNothings(Dielectric(0, 1.5f), 62, {Medium(2, 0.95f, HG(0.3f)), Diffuse(0.8f)}), 20000, 20000},
        {"smooth_thinnest_medium_smooth",
         {Dielectric(0, 1.5f), Medium(0.001f, 1, Isotropic()), Dielectric(0, 1 / 1.5f)},
         2000000,
         40000},
        {"smooth_thinnest_medium_nothings_smooth",
         WithNothings(Dielectric(0, 1.5f), 5,
                      {Medium(0.001f, 1, HG(0.5f)), Nothing(), Dielectric(0, 1 / 1.5f)}),
         2000000, 120000},
        {"smooth_thin_medium_mirror",
         {Dielectric(0, 1.5f), Medium(0.003f, 1, Isotropic()), Mirror(0)},
         1000000,
         40000},
        {"smooth_thin_coloured_medium_mirror",
         {Dielectric(0, 1.5f),
          Medium(Lanes(0.001f, 0.003f, 0.01f, 0.03f), Lanes(1, 0.9f, 0.7f, 0.5f), HG(0.5f)), Mirror(0)},
         1000000,
         40000},
    };
    return cases;
}

/// Values by an estimator against walks; a deviation has to show itself twice.
Agreement ExamineLongWalks(const LongWalkCase& row, const LayeredEstimator& estimator, TransportMode mode,
                           uint64_t seed) {
    Arena arena;
    const Stack stack = StackCase{.name = row.name, .layers = row.layers}.Build(arena);
    const ValueFunction f = [&](Vec3 wi, Rng& rng) {
        return estimator.Evaluate(stack, kOblique, wi, {mode, Lobes::BothSides, &rng, false},
                                  kMaxPathVertices);
    };
    const int numValues = Scaled(row.numValues);
    return Examine({stack, kOblique, mode}, f, {Scaled(row.numWalks), numValues, 1, numValues}, seed,
                   kSuspicious);
}

/// Relative standard error of an albedo that is allowed. Walks whose flights are not forced to scatter have
/// 20 % between smooth interfaces.
constexpr double kLargestError = 0.06;
double IncreaseOfErrors() { return std::sqrt(8. / Scaled(8)); }

class LayeredLongWalksLong : public testing::TestWithParam<std::string> {};

// Power: errors of 1 to 3 % in each stack, 5 % in the one with a thin slab between interfaces that are not
// there. A light's walk that was cut at 160 vertices lost 6 % and 34 % of the first two, and 20 % behind thin
// slabs.
TEST_P(LayeredLongWalksLong, LoseNothing) {
    const std::vector<LongWalkCase>& rows = LongWalkCases();
    const double alpha = SidakAlpha(1e-3, int(rows.size()) * 2 * kNumMoments * 6);
    const LayeredEstimator* estimator = FindEstimator(GetParam());
    std::mutex mutex;
    ParallelFor(int64_t(2 * rows.size()), [&](int64_t i) {
        const LongWalkCase& row = rows[size_t(i / 2)];
        const TransportMode mode = i % 2 ? TransportMode::Importance : TransportMode::Radiance;
        const Agreement a =
            ExamineLongWalks(row, *estimator, mode, SeedOf(row.name + GetParam() + char('0' + i % 2)));
        EXPECT_GE(NormalTwoSided(a.WorstZ()), alpha)
            << row.name << ": " << a.comparison.Describe(a.values, a.walks);
        const std::lock_guard lock(mutex);
        RecordProperty(fmt::format("{} {}", row.name, i % 2),
                       fmt::format("{:.6f} +- {:.6f}, walks {:.6f} +- {:.6f}", a.values.Albedo(),
                                   a.values.AlbedoError(), a.walks.Albedo(), a.walks.AlbedoError()));
        EXPECT_LT(a.values.AlbedoError(), kLargestError * a.values.Albedo() * IncreaseOfErrors())
            << row.name << ": the comparison means nothing";
    });
}

INSTANTIATE_TEST_SUITE_P(, LayeredLongWalksLong,
                         testing::Values("bidirectional", "unidirectional", "auto", "halfvector",
                                         "pairproduct", "multiproduct"));

struct CutsTheLightsWalk : WalkPolicy {
    static constexpr int kMaxLightVertices = 40;
};

TEST(LayeredLongWalksControlLong, SeesCutWalks) {
    const double alpha = SidakAlpha(1e-3, 14 * kNumMoments * 6);
    for (const LongWalkCase& row : LongWalkCases()) {
        if (row.name.find("sixty") == std::string::npos) continue;
        const Agreement a = ExamineLongWalks(row, WalkEstimator<CutsTheLightsWalk>(), TransportMode::Radiance,
                                             SeedOf(FullTestName() + row.name));
        EXPECT_LT(NormalTwoSided(a.WorstZ()), alpha) << row.name;
    }
}

}  // namespace
}  // namespace lacquer::layered::test::long_walks_test
