// The learned density over directions: it is one, it is what is drawn, and it is of what was added alone.
#include "pbrt/guiding/directional_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pbrt/core/math.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::directional_tree_test {
namespace {

struct Found {
    Vec3 w;
    int64_t amount;
};
/// Light from a narrow lamp over that of a half of all directions.
std::vector<Found> LampAndSky(uint64_t seed) {
    Rng rng(seed);
    std::vector<Found> found;
    const Vec3 lamp = Normalize({0.3f, 0.8f, -0.5f});
    for (int i = 0; i < 4000; ++i) {
        const Vec3 w = EqualAreaSquareToSphere(rng.Uniform2D());
        found.push_back({w.y < 0 ? -w : w, 1000});
        const Vec3 offset = 0.02f * (Vec3(rng.Uniform(), rng.Uniform(), rng.Uniform()) - Vec3(0.5f));
        found.push_back({Normalize(lamp + offset), 3000});
    }
    return found;
}
DirectionalTree Learned(const std::vector<Found>& found, int times = 3) {
    DirectionalTree tree;
    for (int i = 0; i < times; ++i) {
        for (const Found& f : found) tree.Add(f.w, f.amount);
        tree.Rebuild();
    }
    return tree;
}

/// Of middles of a grid as fine as the deepest leaves would need where the tree is that deep.
double IntegralOf(const DirectionalTree& tree) {
    constexpr int kSide = 1024;
    double sum = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            sum += double(tree.Pdf(EqualAreaSquareToSphere((Point2(x, y) + 0.5f) / float(kSide))));
    return sum * 4 * double(Pi) / (kSide * kSide);
}

TEST(DirectionalTree, IsUniformWhereNothingWasAdded) {
    DirectionalTree tree;
    tree.Rebuild();
    Rng rng(1);
    for (int i = 0; i < 1000; ++i)
        EXPECT_NEAR(tree.Pdf(EqualAreaSquareToSphere(rng.Uniform2D())), 1 / (4 * Pi), 1e-6f);
}

TEST(DirectionalTree, IntegratesToOne) {
    EXPECT_NEAR(IntegralOf(Learned(LampAndSky(1))), 1, 1e-4);
    EXPECT_NEAR(IntegralOf(DirectionalTree()), 1, 1e-5);
}

TEST(DirectionalTree, GoesWhereTheLightIs) {
    const DirectionalTree tree = Learned(LampAndSky(2));
    // Three quarters of it within less than 0.0004 sr.
    EXPECT_GT(tree.Pdf(Normalize({0.3f, 0.8f, -0.5f})), 300);
    EXPECT_LT(tree.Pdf(Normalize({0.3f, 0.8f, 0.5f})), 0.1f);
    EXPECT_EQ(tree.Pdf(Normalize({0.3f, -0.8f, 0.5f})), 0);
}

/// Draws in a grid over the square against the integral of the density there. @param tilt  of the density,
/// by a control
test::Outcome DrawsAgree(const DirectionalTree& tree, double tilt, uint64_t seed) {
    constexpr int kSide = 16, kFine = 64, kDraws = 200000;
    std::vector<double> observed(kSide * kSide), expected(kSide * kSide);
    Rng rng(seed);
    for (int i = 0; i < kDraws; ++i) {
        const Point2 p = EqualAreaSphereToSquare(tree.Sample(rng.Uniform2D()).w);
        const auto cell = [](float x) { return std::min(int(x * kSide), kSide - 1); };
        ++observed[size_t(cell(p.y) * kSide + cell(p.x))];
    }
    for (int y = 0; y < kSide * kFine; ++y)
        for (int x = 0; x < kSide * kFine; ++x) {
            const Point2 p = (Point2(x, y) + 0.5f) / float(kSide * kFine);
            const double part = 4 * double(Pi) / (kSide * kFine * kSide * kFine);
            expected[size_t(y / kFine * kSide + x / kFine)] += kDraws * part *
                                                               double(tree.Pdf(EqualAreaSquareToSphere(p))) *
                                                               (1 + tilt * (double(p.x) - 0.5));
        }
    return test::ChiSquareTest(observed, expected);
}
// Power: a density that is wrong by 5 % at the ends of the square is found.
TEST(DirectionalTree, DrawsWhatItsDensitySays) {
    EXPECT_TRUE(test::Passes(test::FullTestName(), 1e-5,
                             [](uint64_t seed) { return DrawsAgree(Learned(LampAndSky(3)), 0, seed); }));
}
TEST(DirectionalTree, NegativeControlAWrongDensityIsFound) {
    EXPECT_LT(DrawsAgree(Learned(LampAndSky(3)), 0.1, test::SeedOf(test::FullTestName())).pValue, 1e-5);
}

TEST(DirectionalTree, TellsTheDensityOfADraw) {
    const DirectionalTree tree = Learned(LampAndSky(4));
    Rng rng(5);
    int differ = 0;
    for (int i = 0; i < 100000; ++i) {
        const auto [w, pdf] = tree.Sample(rng.Uniform2D());
        ASSERT_GT(pdf, 0);
        ASSERT_NEAR(Length(w), 1, 1e-5f);
        differ += tree.Pdf(w) != pdf;
    }
    EXPECT_LT(differ, 100) << "more than rounding at the borders of leaves";
    for (const float x : {0.f, 0x1p-32f, 0.5f, OneMinusEpsilon})
        for (const float y : {0.f, 0.5f, OneMinusEpsilon}) EXPECT_GT(tree.Sample({x, y}).pdf, 0);
}

TEST(DirectionalTree, DoesNotDependOnOrder) {
    std::vector<Found> found = LampAndSky(6);
    const DirectionalTree tree = Learned(found);
    std::reverse(found.begin(), found.end());
    const DirectionalTree other = Learned(found);
    ASSERT_EQ(tree.NumLeaves(), other.NumLeaves());
    Rng rng(7);
    for (int i = 0; i < 10000; ++i) {
        const Point2 u = rng.Uniform2D();
        EXPECT_EQ(tree.Sample(u).w, other.Sample(u).w);
    }
}

// A single direction with amounts from one unit to what sums can hold.
TEST(DirectionalTree, HoldsTinyAndHugeAmounts) {
    for (const int64_t amount : {int64_t(1), int64_t(1) << 39, int64_t(1) << 60}) {
        const Vec3 w = Normalize({-0.2f, -0.9f, 0.1f});
        const DirectionalTree tree = Learned({{w, amount}}, 6);
        EXPECT_GT(tree.Pdf(w), 1e4f) << amount;
        EXPECT_TRUE(std::isfinite(tree.Pdf(w)));
        EXPECT_GT(Dot(tree.Sample({0.5f, 0.5f}).w, w), 0.999f) << amount;
        EXPECT_LT(tree.NumLeaves(), 50u);
    }
}
// Leaves that hold little are joined: what was lit once does not make a tree grow.
TEST(DirectionalTree, Forgets) {
    DirectionalTree tree = Learned(LampAndSky(8));
    const Vec3 w = Normalize({0.f, -1.f, 0.2f});
    for (int i = 0; i < 12; ++i) {
        tree.Add(w, int64_t(1) << 40);
        tree.Rebuild();
    }
    EXPECT_LT(tree.NumLeaves(), 50u);
    EXPECT_LT(tree.Pdf(Normalize({0.3f, 0.8f, -0.5f})), 1e-3f);
}

}  // namespace
}  // namespace lacquer::directional_tree_test
