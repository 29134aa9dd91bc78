#include <gtest/gtest.h>

#include "bulk/waves/harmonics.h"
#include "bulk/waves/regular_translation.h"
#include "bulk/waves/translation.h"
#include "bulk/waves/wigner.h"

namespace lacquer::test::waves_test {
namespace {

using namespace bulk;

TEST(WignerD, HasTheKnownValues) {
    const WignerD d(5, 0.7, 5);
    EXPECT_NEAR(d.At(2, 1, -1), 0.29743752219212377, 1e-15);
    EXPECT_NEAR(d.At(4, 3, 1), 0.4988434986655759, 1e-15);
    EXPECT_NEAR(d.At(4, -2, 3), 0.04214944276577141, 1e-15);
    EXPECT_NEAR(d.At(1, 1, 0), -std::sin(0.7) / std::sqrt(2.), 1e-15);
}

TEST(WignerD, IsOrthogonalUpToHighDegrees) {
    for (const double beta : {0., 0.01, 1.3, 3.0, 3.141592653589793}) {
        const WignerD d(90, beta, 90);
        for (const int n : {1, 13, 79, 80, 81, 90}) {
            const Eigen::MatrixXd& m = d.Of(n);
            EXPECT_LT(
                (m * m.transpose() - Eigen::MatrixXd::Identity(2 * n + 1, 2 * n + 1)).cwiseAbs().maxCoeff(),
                1e-10)
                << beta << " " << n;
        }
    }
}

// Along z, kd = 5: the factors that the other entries are made of.
TEST(Translation, AlongZHasTheKnownValues) {
    const int degree = 6, size = NumHarmonics(degree);
    const Eigen::MatrixXcd matrix = Translation({0, 0, 5}, degree, degree).Matrix();
    const auto a = [&](int m, int nu, int n) { return matrix(HarmonicIndex(nu, m), HarmonicIndex(n, m)); };
    const auto b = [&](int m, int nu, int n) {
        return matrix(size + HarmonicIndex(nu, m), HarmonicIndex(n, m));
    };
    const auto expectNear = [](Complex found, Complex expected) {
        EXPECT_LT(std::abs(found - expected), 1e-12 * std::abs(expected)) << found << expected;
    };
    expectNear(a(0, 1, 1), {-0.0570536448475024, 0.1082630205084592});
    expectNear(a(1, 1, 1), {-0.2591504599751903, -0.1392301658931975});
    expectNear(b(1, 1, 1), {-0.270657551271148, -0.1426341121187562});
    expectNear(a(1, 3, 2), {0.0234524063413067, 0.2043614069162822});
    expectNear(b(1, 3, 2), {0.5337438890728288, 0.2812782623620459});
    expectNear(a(2, 3, 5), {0.2740277728483698, -2.471803563681663});
    expectNear(b(2, 3, 5), {-2.3943255131261125, 0.1183461001764679});
}

// Values of a published package with the same normalisation, treams [Beutel et al. 2024].
TEST(Translation, InAnyDirectionHasThePublishedValues) {
    const int degree = 8, size = NumHarmonics(degree);
    const Point d = 8 * Direction{7, 6}.Vector();
    const Eigen::MatrixXcd outgoing = Translation(d, degree, degree).Matrix();
    const Eigen::MatrixXcd regular = RegularTranslation(degree, degree, 8).Matrix(d);
    const int to = HarmonicIndex(5, 4), from = HarmonicIndex(3, 2);
    EXPECT_LT(std::abs(outgoing(to, from) - Complex(-0.024574996806028, -0.103410185698746)), 1e-14);
    EXPECT_LT(std::abs(outgoing(size + to, from) - Complex(0.110199536665973, -0.046588877470371)), 1e-14);
    EXPECT_LT(std::abs(regular(to, from) - Complex(-0.064322610568195, -0.040900170567219)), 1e-14);
    EXPECT_LT(std::abs(regular(size + to, from) - Complex(0.052822542970675, -0.083072608588279)), 1e-14);
}

/// Largest difference between the fields of random waves about the origin and of their translation to d, over
/// that field, at points about d. @param flipB  a control: N waves take the other sign in what M waves become
double FieldError(const Point& d, bool isRegular, bool flipB) {
    constexpr int kFrom = 4, kTo = 22;
    const Eigen::VectorXcd waves = Eigen::VectorXcd::Random(2 * NumHarmonics(kFrom));
    Eigen::MatrixXcd matrix =
        isRegular ? RegularTranslation(kFrom, kTo, d.norm()).Matrix(d) : Translation(d, kFrom, kTo).Matrix();
    if (flipB) {
        matrix.bottomLeftCorner(NumHarmonics(kTo), NumHarmonics(kFrom)) *= -1;
        matrix.topRightCorner(NumHarmonics(kTo), NumHarmonics(kFrom)) *= -1;
    }
    const Eigen::VectorXcd translated = matrix * waves;
    double worst = 0;
    for (const Direction s : {Direction{0.3, 1}, Direction{2.4, -2}, Direction{1.5, 3}}) {
        const Point offset = 0.1 * d.norm() * s.Vector();
        const Eigen::Vector3cd before = FieldAt(waves, kFrom, d + offset, isRegular);
        const Eigen::Vector3cd after = FieldAt(translated, kTo, offset, true);
        worst = std::max(worst, (after - before).norm() / before.norm());
    }
    return worst;
}

TEST(Translation, KeepsTheFields) {
    for (const Point& d :
         {Point(3, -4, 5), Point(0, 0, 6), Point(0, 0, -6), Point(1, 7, 0), Point(1e-9, 0, 4)})
        for (const bool isRegular : {false, true}) {
            EXPECT_LT(FieldError(d, isRegular, false), 1e-10) << d.transpose();
            EXPECT_GT(FieldError(d, isRegular, true), 0.1) << d.transpose();
        }
}

// Between spheres that nearly touch, where the recurrence loses most: the field of waves of degree 80 within
// the other sphere.
TEST(Translation, HoldsSevenDigitsAtDegreeEighty) {
    constexpr int kDegree = 80;
    const double radius = 61;
    const Point d = 2 * radius * Direction{0.7, 1}.Vector();
    const Translation translation(d, kDegree, kDegree);
    for (const int m : {0, 1, 40, 80}) {
        Eigen::VectorXcd waves = Eigen::VectorXcd::Zero(2 * NumHarmonics(kDegree));
        waves[HarmonicIndex(80, m)] = 1;
        const Eigen::VectorXcd translated = translation.Apply(waves);
        double error = 0, scale = 0;
        for (const Direction s : {Direction{0.3, 1}, Direction{2.4, -2}, Direction{1.5, 3}}) {
            const Point offset = 0.4 * radius * s.Vector();
            const Eigen::Vector3cd before = FieldAt(waves, kDegree, d + offset, false);
            error = std::max(error, (FieldAt(translated, kDegree, offset, true) - before).norm());
            scale = std::max(scale, before.norm());
        }
        EXPECT_LT(error, 2e-7 * scale) << m;
    }
}

TEST(RegularTranslation, IsUndoneByTheWayBackWhichIsItsAdjoint) {
    const Eigen::MatrixXcd waves = Eigen::MatrixXcd::Random(2 * NumHarmonics(3), 2);
    const Point d(0.4, -0.5, 0.3);
    const RegularTranslation there(3, 18, 1), back(18, 3, 1);
    EXPECT_LT((back.Apply(-d, there.Apply(d, waves)) - waves).norm(), 1e-12);
    EXPECT_LT((back.Matrix(-d) - there.Matrix(d).adjoint()).norm(), 1e-12);
}

TEST(RegularTranslation, ByNothingIsNothing) {
    const Eigen::MatrixXcd matrix = RegularTranslation(5, 5, 0).Matrix({0, 0, 0});
    EXPECT_LT((matrix - Eigen::MatrixXcd::Identity(matrix.rows(), matrix.cols())).cwiseAbs().maxCoeff(),
              1e-14);
}

TEST(Harmonics, PlaneWavesAreTheirSeries) {
    for (const Direction n :
         {Direction{0, 0}, Direction{0, 0.7}, Direction{1.1, 2}, Direction{3.141592653589793, 1}}) {
        const Eigen::MatrixX2cd waves = PlaneWave(20, n);
        const Point theta = Direction{n.theta + 1.5707963267948966, n.phi}.Vector();
        const Point phi(-std::sin(n.phi), std::cos(n.phi), 0);
        for (const Point& p : {Point(0.4, -1.1, 0.7), Point(-2, 1, 1.5)}) {
            const Complex phase = std::polar(1., n.Vector().dot(p));
            EXPECT_LT((FieldAt(waves.col(0), 20, p, true) - phase * theta.cast<Complex>()).norm(), 1e-11);
            EXPECT_LT((FieldAt(waves.col(1), 20, p, true) - phase * phi.cast<Complex>()).norm(), 1e-11);
        }
    }
}

TEST(Harmonics, BesselFunctionsHoldAtZerosAndFarAway) {
    // j_0 is zero at pi; j_1 by its closed form; the Wronskian j_n y_{n-1} - j_{n-1} y_n = 1/x^2.
    for (const double x : {1e-3, 0.5, 3.141592653589793, 4.493409457909064, 25., 150.}) {
        const Eigen::VectorXd j = SphericalBesselJ(30, x), y = SphericalBesselY(30, x);
        for (int n = 1; n <= 30; ++n) {
            if (!std::isfinite(y[n])) break;
            EXPECT_NEAR((j[n] * y[n - 1] - j[n - 1] * y[n]) * x * x, 1, 1e-10) << x << " " << n;
        }
    }
}

}  // namespace
}  // namespace lacquer::test::waves_test
