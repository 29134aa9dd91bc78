#include <gtest/gtest.h>

#include <numbers>

#include "bulk/ensembles/hard_spheres.h"
#include "bulk/ensembles/radius_distribution.h"
#include "bulk/ensembles/structure.h"
#include "support/statistics.h"

namespace lacquer::test::ensembles_test {
namespace {

using namespace bulk;

TEST(PercusYevick, HasTheKnownValues) {
    EXPECT_NEAR(PercusYevickStructureFactor(0.1, 0.5), 0.461558903, 1e-9);
    EXPECT_NEAR(PercusYevickStructureFactor(0.1, 3), 0.692609588, 1e-9);
    EXPECT_NEAR(PercusYevickStructureFactor(0.1, 2 * std::numbers::pi), 1.083162529, 1e-9);
    EXPECT_NEAR(PercusYevickStructureFactor(0.3, 0), 0.093789062, 1e-9);
    EXPECT_NEAR(PercusYevickStructureFactor(0.3, 3), 0.193531392, 1e-9);
    // No jump where the closed form at zero takes over.
    EXPECT_NEAR(PercusYevickStructureFactor(0.3, 0.0501) / PercusYevickStructureFactor(0.3, 0.0499), 1, 1e-3);
}

// At contact the equation has a closed solution; far away particles know nothing of each other.
TEST(PercusYevick, PairsTouchAsTheClosedFormSays) {
    for (const double phi : {0.01, 0.1, 0.3, 0.45}) {
        const double contact = (1 + phi / 2) / ((1 - phi) * (1 - phi));
        EXPECT_NEAR(PercusYevickPairDistribution(phi, 1), contact, 1e-3 * contact) << phi;
        // Power: the value a tenth of a diameter farther is another one.
        EXPECT_GT(contact - PercusYevickPairDistribution(phi, 1.1), 0.1 * (contact - 1)) << phi;
        EXPECT_NEAR(PercusYevickPairDistribution(phi, 9), 1, 2e-3) << phi;
        EXPECT_EQ(PercusYevickPairDistribution(phi, 0.99), 0);
    }
    // To first order in the density: 1 + 8 phi (1 - 3x/4 + x^3/16).
    EXPECT_NEAR(PercusYevickPairDistribution(1e-3, 1.5), 1 + 8e-3 * (1 - 1.125 + 3.375 / 16), 2e-4);
}

TEST(RadiusDistribution, SamplesHaveItsMoments) {
    // Power: at 200,000 samples an error of 1 % of any of these moments is six deviations or more.
    for (const RadiusDistribution& d :
         {RadiusDistribution::Normal(2, 0.4), RadiusDistribution::Normal(1, 0.8),
          RadiusDistribution::LogNormal(0.25, 0.4), RadiusDistribution::Constant(3),
          RadiusDistribution::Table({{1, 2}, {2, 1}, {5, 0.5}})}) {
        Random random(SeedOf(FullTestName()));
        const int n = Scaled(200000);
        double sums[3] = {}, squares[3] = {};
        for (int i = 0; i < n; ++i) {
            const double r = d.Sample(random);
            ASSERT_GT(r, 0);
            ASSERT_LE(r, d.Largest() * (1 + 1e-12));
            for (int k = 0; k < 3; ++k) {
                sums[k] += std::pow(r, k + 1);
                squares[k] += std::pow(r, 2 * k + 2);
            }
        }
        for (int k = 0; k < 3; ++k) {
            const double mean = sums[k] / n,
                         error = std::sqrt(std::max(0., squares[k] / n - mean * mean) / n);
            EXPECT_NEAR(mean, d.Moment(k + 1), 4.5 * error + 1e-9) << k;
        }
    }
}

/// The largest overlap of two spheres, and the largest part that sticks out of a ball.
double WorstOverlap(const Domain& domain, const HardSpheres& spheres, const std::vector<double>& radii) {
    double worst = -1e9;
    const std::vector<Point>& centers = spheres.Centers();
    for (size_t i = 0; i < centers.size(); ++i) {
        if (domain.kind == Domain::Kind::Ball)
            worst = std::max(worst, centers[i].norm() + radii[i] - domain.size);
        for (size_t j = 0; j < i; ++j)
            worst = std::max(worst, radii[i] + radii[j] - domain.Displacement(centers[i], centers[j]).norm());
    }
    return worst;
}

TEST(HardSpheres, DoNotOverlapAtAnyDensity) {
    for (const double fraction : {0.01, 0.2, 0.4, 0.5})
        for (const Domain::Kind kind : {Domain::Kind::Ball, Domain::Kind::PeriodicBox}) {
            Random random(SeedOf(FullTestName()));
            std::vector<double> radii;
            double volume = 0;
            for (int i = 0; i < 120; ++i) {
                radii.push_back(i % 3 == 0 ? 1.3 : 0.8);
                volume += 4 * std::numbers::pi / 3 * std::pow(radii.back(), 3);
            }
            Domain domain{kind, 1};
            domain.size = std::cbrt(volume / fraction / domain.Volume());
            HardSpheres spheres(domain, radii);
            ASSERT_TRUE(spheres.AddAllByGrowth(random)) << fraction;
            spheres.Move(random, 20);
            EXPECT_EQ(spheres.Count(), 120);
            EXPECT_LE(WorstOverlap(domain, spheres, radii), 1e-9) << fraction;
            // Control: a little larger they would.
            std::vector<double> larger = radii;
            for (double& r : larger) r *= 1.5;
            EXPECT_GT(WorstOverlap(domain, spheres, larger), 0) << fraction;
        }
}

TEST(HardSpheres, SayWhenThereIsNoRoom) {
    Random random(1);
    HardSpheres spheres({Domain::Kind::Ball, 2}, std::vector<double>(20, 1.));
    EXPECT_FALSE(spheres.AddAll(random, 200));
}

// Fluctuations of hard spheres in a ball that is cut from a large box; near q = 0 the ball's surface adds to
// them.
TEST(Structure, OfHardSpheresIsThatOfPercusAndYevick) {
    const double fraction = 0.1, radius = 1, ball = 11, side = 2.5 * ball;
    const Domain box{Domain::Kind::PeriodicBox, side};
    const int count = int(std::lround(fraction * box.Volume() / (4 * std::numbers::pi / 3)));
    const std::vector<double> wavenumbers = {1.5, 2, 2.5, 3, 3.5, 4};
    StructureSums hard(wavenumbers, 0.25, 30), independent(wavenumbers, 0.25, 30);
    for (uint64_t r = 0; r < 40; ++r) {
        Random random(Hash(SeedOf(FullTestName()), r));
        HardSpheres spheres(box, std::vector<double>(size_t(count), radius));
        ASSERT_TRUE(spheres.AddAllByGrowth(random));
        spheres.Move(random, 20);
        const Point middle = box.RandomPoint(random);
        std::vector<Point> inside, points;
        for (const Point& center : spheres.Centers()) {
            const Point p = box.Displacement(middle, center);
            if (p.norm() <= ball) inside.push_back(p);
            const Point q = box.RandomPoint(random);
            if (q.norm() <= ball) points.push_back(q);
        }
        hard.Add(inside);
        independent.Add(points);
    }
    const std::vector<double> found = hard.StructureFactor(), control = independent.StructureFactor();
    for (size_t k = 0; k < wavenumbers.size(); ++k) {
        EXPECT_NEAR(found[k], PercusYevickStructureFactor(fraction, 2 * wavenumbers[k]), 0.06) << k;
        EXPECT_NEAR(control[k], 1, 0.06) << k;
    }
    const std::vector<double> g = hard.PairDistribution(ball);
    for (size_t i = 0; i < 8; ++i) EXPECT_EQ(g[i], 0) << i;
    EXPECT_GT(g[8], 1.15);
    EXPECT_NEAR(g[24], 1, 0.06);
}

}  // namespace
}  // namespace lacquer::test::ensembles_test
