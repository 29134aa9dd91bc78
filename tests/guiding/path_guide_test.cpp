// What a guide makes of paths: where light comes from one side, it draws from there; where it comes from
// everywhere or from nowhere, it leaves the work to scattering.
#include "pbrt/guiding/path_guide.h"

#include <gtest/gtest.h>

#include <functional>

#include "pbrt/core/math.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"

namespace lacquer::path_guide_test {
namespace {

const Bounds3 kBounds{Point3(-1, -2, -3), Point3(5, 4, 3)};

using Light = std::function<double(Point3 p, Vec3 wi)>;

/// Paths of one vertex on a floor that scatters alike to all sides, which find light(p, wi) there.
void LearnPass(PathGuide* guide, const Light& light, int count, uint64_t seed) {
    Rng rng(seed);
    for (int i = 0; i < count; ++i) {
        const Point3 p(-1 + 6 * rng.Uniform(), -2, -3 + 6 * rng.Uniform());
        const GuidedDensity density = guide->At(p, GuidedFacing::UpY, GuidedKind::Diffuse);
        ASSERT_TRUE(density);
        const bool isScattered = rng.Uniform() < density.ScatteringShare();
        Vec3 w = SampleCosineHemisphere(rng.Uniform2D());
        w = isScattered ? Vec3(w.x, w.z, w.y) : density.Cell().Directions().Sample(rng.Uniform2D()).w;
        if (w.y <= 0) continue;
        GuidedVertex vertex;
        vertex.wi = w;
        vertex.cosine = w.y;
        vertex.density = density;
        vertex.scattering = w.y / Pi;
        vertex.learned = density.Learned(w);
        vertex.throughputBefore = 1;
        vertex.throughput = double(vertex.scattering / density.Of(vertex.scattering, vertex.learned));
        GuidedPath path;
        path.Add(vertex);
        guide->Learn(path, float(vertex.throughput * light(p, w)));
    }
}
PathGuide Learned(const Light& light, int numPasses = 5) {
    PathGuide guide(kBounds);
    for (int pass = 0; pass < numPasses; ++pass) {
        LearnPass(&guide, light, 4000 << pass, uint64_t(pass));
        guide.EndPass(pass + 1 == numPasses);
    }
    return guide;
}
const Vec3 kLamp = Normalize({0.5f, 0.7f, 0.2f});
double LampAlone(Point3, Vec3 wi) { return Dot(wi, kLamp) > 0.995f ? 1 : 0; }

TEST(PathGuide, DrawsFromWhereTheLightIs) {
    const PathGuide guide = Learned(LampAlone);
    EXPECT_TRUE(guide.IsUsed());
    EXPECT_FALSE(guide.IsLearning());
    const GuidedDensity density = guide.At({1, -2, 0}, GuidedFacing::UpY, GuidedKind::Diffuse);
    ASSERT_TRUE(density);
    EXPECT_LE(density.ScatteringShare(), 0.35f);
    // Uniform within the lamp's 0.031 sr, it would be 32.
    EXPECT_GT(density.Learned(kLamp), 15);
    EXPECT_LT(density.Learned(Normalize(Vec3(-0.5f, 0.7f, 0.2f))), 0.01f);
}
TEST(PathGuide, TellsPlacesApart) {
    // From the right where x is small, else from the left.
    const PathGuide guide = Learned([](Point3 p, Vec3 wi) {
        return Dot(wi, Normalize({p.x < 2 ? 1.f : -1.f, 0.5f, 0.f})) > 0.99f ? 1. : 0.;
    });
    const auto learned = [&](float x, float side) {
        return guide.At({x, -2, 1}, GuidedFacing::UpY, GuidedKind::Diffuse)
            .Learned(Normalize(Vec3(side, 0.5f, 0)));
    };
    EXPECT_GT(learned(0, 1), 100 * learned(0, -1));
    EXPECT_GT(learned(4, -1), 100 * learned(4, 1));
    EXPECT_GT(guide.NumCells(), 16u);
}
TEST(PathGuide, LeavesWhatNothingWasLearnedOf) {
    const PathGuide guide = Learned(LampAlone);
    EXPECT_FALSE(guide.At({1, -2, 0}, GuidedFacing::DownY, GuidedKind::Diffuse)) << "the other side";
    EXPECT_FALSE(guide.At({1, -2, 0}, GuidedFacing::UpY, GuidedKind::Glossy)) << "another kind";
    EXPECT_FALSE(guide.At({1, 0, 0}, GuidedFacing::Volume, GuidedKind::Volume));
}
TEST(PathGuide, IsOfNoUseUnderAnEvenSky) {
    const PathGuide guide = Learned([](Point3, Vec3) { return 1.; });
    EXPECT_FALSE(guide.IsUsed());
    EXPECT_FALSE(guide.At({1, -2, 0}, GuidedFacing::UpY, GuidedKind::Diffuse));
}
TEST(PathGuide, IsOfNoUseWithoutLight) {
    EXPECT_FALSE(Learned([](Point3, Vec3) { return 0.; }).IsUsed());
}

// Light of any unit makes the same guide; one that cannot be counted makes none.
TEST(PathGuide, DoesNotDependOnTheUnitOfLight) {
    const auto shareAndDensity = [](double unit) {
        const PathGuide guide = Learned([&](Point3 p, Vec3 wi) { return unit * LampAlone(p, wi); });
        const GuidedDensity density = guide.At({1, -2, 0}, GuidedFacing::UpY, GuidedKind::Diffuse);
        return std::pair(density.ScatteringShare(), density ? density.Learned(kLamp) : -1);
    };
    const auto [share, learned] = shareAndDensity(1);
    for (const double unit : {0x1p-90, 0x1p-30, 0x1p30, 0x1p90}) {
        const auto [otherShare, otherLearned] = shareAndDensity(unit);
        EXPECT_EQ(share, otherShare) << unit;
        EXPECT_NEAR(learned, otherLearned, 0.01f * learned) << unit;
    }
    const auto [infiniteShare, infiniteLearned] = shareAndDensity(std::numeric_limits<double>::infinity());
    EXPECT_TRUE(infiniteShare >= 0 && infiniteShare <= 1 && !std::isnan(infiniteLearned));
}
// A path of two vertices: at the first, light of the second's surroundings counts, and not what the path
// found there by itself.
TEST(PathGuide, ExpectsWhatOthersHaveFoundBeyondTheNextVertex) {
    PathGuide guide(kBounds);
    const Vec3 aside = Normalize({1.f, 0.3f, 0.f}), up(0, 1, 0);
    for (int pass = 0; pass < 5; ++pass) {
        for (int i = 0; i < 2000 << pass; ++i) {
            const auto vertex = [&](Point3 p, Vec3 wi) {
                GuidedVertex v;
                v.wi = wi;
                v.density = guide.At(p, GuidedFacing::Volume, GuidedKind::Volume);
                v.scattering = 1 / (4 * Pi);
                v.learned = v.density.Learned(wi);
                v.throughputBefore = v.throughput = 1;
                return v;
            };
            // One path in a hundred finds light, and all of them by the same surroundings.
            GuidedPath path;
            path.Add(vertex({0, 0, 0}, i % 2 ? aside : up));
            path.Add(vertex(i % 2 ? Point3(4, 3, 0) : Point3(0, 3, 2), up));
            guide.Learn(path, i % 200 == 1 ? 100.f : 0.f);
        }
        guide.EndPass(pass == 4);
    }
    const GuidedDensity density = guide.At({0, 0, 0}, GuidedFacing::Volume, GuidedKind::Volume);
    ASSERT_TRUE(density);
    EXPECT_GT(density.Learned(aside), 100 * std::max(density.Learned(up), 0.01f));
}
// Scenes without an extent, and places outside of it.
TEST(PathGuide, TakesAnyPlace) {
    for (const Bounds3& bounds : {Bounds3(), Bounds3(Point3(1), Point3(1)), kBounds}) {
        PathGuide guide(bounds);
        for (const float x : {-1e30f, -1.f, 0.f, 1e30f}) {
            const GuidedDensity density = guide.At({x, x, x}, GuidedFacing::BackZ, GuidedKind::Diffuse);
            ASSERT_TRUE(density);
            EXPECT_NEAR(density.Learned({0, 0, 1}), 1 / (4 * Pi), 1e-6f);
        }
    }
}

}  // namespace
}  // namespace lacquer::path_guide_test
