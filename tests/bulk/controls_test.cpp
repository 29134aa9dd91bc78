// A second, small and slow solution of clusters, from translations as matrices: right it agrees with the
// known numbers, and each of the mistakes that are easily made here is seen.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "bulk/reference_case.h"
#include "bulk/waves/harmonics.h"
#include "bulk/waves/translation.h"

namespace lacquer::test::controls_test {
namespace {

using namespace bulk;
using std::numbers::pi;

enum class Mistake {
    None,
    SignOfB,           ///< of what M waves give to N waves
    SignOfWayBack,     ///< B of -d has the sign of that of d
    PowerOfI,          ///< i^n for i^(n-1) in the plane wave's N part
    SwappedT,          ///< magnetic for electric
    FewDegrees,        ///< 6 x / (2 pi) + 1.5, rounded up
    NoCrossed,         ///< S_11 of the diagonal alone
    CoherentForTotal,  ///< the square of a mean for the mean of squares
    FewAzimuths        ///< 8 azimuths
};

struct Found {
    double extinction, scattering, forwardExtinction, integral;
};

/// Of S_11 of the first column (of both for Mistake::NoCrossed), by a quadrature that is exact as far as the
/// mistakes let it be.
double IntegralOfIntensity(const OneOriginWaves& far, Mistake mistake) {
    double integral = 0;
    constexpr int kThetas = 60;
    const std::vector<double> weights = ClenshawCurtisWeights(kThetas);
    const int numPhis = mistake == Mistake::FewAzimuths ? 8 : 2 * far.degree + 1;
    for (int a = 0; a <= kThetas; ++a) {
        const double theta = a * pi / kThetas;
        double squares = 0;
        Eigen::Matrix2cd mean = Eigen::Matrix2cd::Zero();
        for (int b = 0; b < numPhis; ++b) {
            Eigen::Matrix2cd f = far.Amplitude({theta, 2 * pi * b / numPhis});
            if (mistake == Mistake::NoCrossed) {
                // In the scattering plane's basis, incident polarisations turned with it.
                const double phi = 2 * pi * b / numPhis;
                Eigen::Matrix2cd turn;
                turn << std::cos(phi), -std::sin(phi), std::sin(phi), std::cos(phi);
                const Eigen::Matrix2cd g = f * turn;
                squares += (std::norm(g(0, 0)) + std::norm(g(1, 1))) / numPhis;
            } else {
                squares += f.col(0).squaredNorm() / numPhis;
            }
            mean += f / double(numPhis);
        }
        const double s11 = mistake == Mistake::CoherentForTotal ? mean.col(0).squaredNorm() : squares;
        integral += 2 * pi * weights[size_t(a)] * s11 * (mistake == Mistake::NoCrossed ? 0.5 : 1);
    }
    return integral;
}

Found SolveWith(const std::vector<Sphere>& spheres, int degree, Mistake mistake) {
    if (mistake == Mistake::FewDegrees) degree = int(std::ceil(6 * spheres[0].Radius() / (2 * pi) + 1.5));
    const Cluster cluster = Cluster::WithDegree(spheres, degree);
    const int size = NumHarmonics(degree), rows = 2 * size, n = cluster.NumSpheres();
    Eigen::MatrixX2cd wave = PlaneWave(degree, {0, 0});
    if (mistake == Mistake::PowerOfI) wave.bottomRows(size) *= Complex(0, 1);
    Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Identity(n * rows, n * rows);
    Eigen::MatrixXcd incident(n * rows, 2);
    Eigen::VectorXcd t(n * rows);
    for (int i = 0; i < n; ++i) {
        incident.middleRows(i * rows, rows) = std::polar(1., cluster.At(i).center.z()) * wave;
        for (int l = 1; l <= degree; ++l)
            for (int m = -l; m <= l; ++m) {
                Complex magnetic = cluster.TMagnetic(i)[size_t(l - 1)];
                Complex electric = cluster.TElectric(i)[size_t(l - 1)];
                if (mistake == Mistake::SwappedT) std::swap(magnetic, electric);
                t[i * rows + HarmonicIndex(l, m)] = magnetic;
                t[i * rows + size + HarmonicIndex(l, m)] = electric;
            }
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            if (i == j) continue;
            Eigen::MatrixXcd block =
                Translation(cluster.At(i).center - cluster.At(j).center, degree, degree).Matrix();
            if (mistake == Mistake::SignOfB || (mistake == Mistake::SignOfWayBack && i > j)) {
                block.bottomLeftCorner(size, size) *= -1;
                if (mistake == Mistake::SignOfWayBack) block.topRightCorner(size, size) *= -1;
            }
            matrix.block(i * rows, j * rows, rows, rows) = (-t.segment(i * rows, rows)).asDiagonal() * block;
        }
    const Eigen::MatrixXcd c = matrix.partialPivLu().solve(t.asDiagonal() * incident);
    HelicityWaves scattered(n, degree);
    for (int i = 0; i < n; ++i) scattered.Set(i, c.middleRows(i * rows, rows));
    const OneOriginWaves far = AboutOrigin(cluster, scattered, FarFieldDegree(cluster));
    Found found;
    found.extinction = -c.col(0).dot(incident.col(0)).real();
    found.scattering = far.Scattering()[0];
    found.forwardExtinction = 4 * pi * far.Amplitude({0, 0})(0, 0).imag();
    found.integral = IntegralOfIntensity(far, mistake);
    if (mistake == Mistake::NoCrossed) found.scattering = far.Scattering().mean();
    return found;
}

/// The worst relative deviation from the known extinction and of the identities between cross sections.
double Deviation(const ReferenceCase& row, Mistake mistake) {
    const auto& known = row.numbers.at("prototype").at("fixed_beta0");
    const Found found = SolveWith(row.spheres, known.at("sphere_degree"), mistake);
    const double extinction = known.at("k2C_ext_theta"), absorption = known.at("k2C_abs_theta");
    double worst = std::abs(found.extinction / extinction - 1);
    worst = std::max(worst, std::abs(found.forwardExtinction / extinction - 1));
    if (mistake != Mistake::NoCrossed)
        worst = std::max(worst, std::abs(found.scattering / (extinction - absorption) - 1));
    return std::max(worst, std::abs(found.integral / found.scattering - 1));
}

TEST(ClusterControls, RightAgreesAndEveryMistakeIsSeen) {
    const ReferenceCase row = ReferenceCase::Read("cluster5");
    EXPECT_LT(Deviation(row, Mistake::None), 1e-9);
    for (const Mistake mistake :
         {Mistake::SignOfB, Mistake::SignOfWayBack, Mistake::PowerOfI, Mistake::SwappedT, Mistake::FewDegrees,
          Mistake::NoCrossed, Mistake::CoherentForTotal, Mistake::FewAzimuths})
        EXPECT_GT(Deviation(row, mistake), 3e-4) << int(mistake);
}

}  // namespace
}  // namespace lacquer::test::controls_test
