#include "bulk/waves/harmonics.h"

#include <cmath>
#include <numbers>

#include "bulk/waves/wigner.h"
#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

double Normalization(int n) { return std::sqrt((2 * n + 1) / (4 * std::numbers::pi)); }

}  // namespace

VectorHarmonics HarmonicsAt(int degree, Direction direction) {
    const WignerD d(degree, direction.theta, 1);
    VectorHarmonics h{Eigen::MatrixX2cd(NumHarmonics(degree), 2), Eigen::MatrixX2cd(NumHarmonics(degree), 2)};
    for (int n = 1; n <= degree; ++n)
        for (int m = -n; m <= n; ++m) {
            const double plus = d.At(n, m, 1), minus = d.At(n, m, -1);
            const Complex e = Normalization(n) * std::polar(1., m * direction.phi);
            const Complex pi = Complex(0, -0.5 * (plus + minus)) * e, tau = -0.5 * (plus - minus) * e;
            const int row = HarmonicIndex(n, m);
            h.c(row, 0) = pi;
            h.c(row, 1) = -tau;
            h.b(row, 0) = tau;
            h.b(row, 1) = pi;
        }
    return h;
}

Eigen::MatrixX2cd PlaneWave(int degree, Direction n) {
    const VectorHarmonics h = HarmonicsAt(degree, n);
    const int size = NumHarmonics(degree);
    Eigen::MatrixX2cd wave(2 * size, 2);
    for (int l = 1; l <= degree; ++l) {
        const int first = HarmonicIndex(l, -l), count = 2 * l + 1;
        const double scale = 4 * std::numbers::pi;
        wave.middleRows(first, count) = scale * PowerOfI(l) * h.c.middleRows(first, count).conjugate();
        wave.middleRows(size + first, count) =
            scale * PowerOfI(l - 1) * h.b.middleRows(first, count).conjugate();
    }
    return wave;
}

Eigen::Matrix2Xcd FarField(int degree, Direction s) {
    const VectorHarmonics h = HarmonicsAt(degree, s);
    const int size = NumHarmonics(degree);
    Eigen::Matrix2Xcd field(2, 2 * size);
    for (int n = 1; n <= degree; ++n) {
        const int first = HarmonicIndex(n, -n), count = 2 * n + 1;
        field.middleCols(first, count) = PowerOfI(-n - 1) * h.c.middleRows(first, count).transpose();
        field.middleCols(size + first, count) = PowerOfI(-n) * h.b.middleRows(first, count).transpose();
    }
    return field;
}

Eigen::VectorXd SphericalBesselJ(int degree, double x) {
    Eigen::VectorXd j = Eigen::VectorXd::Zero(degree + 1);
    if (x == 0) {
        j[0] = 1;
        return j;
    }
    // Upwards as far as that is stable, to n = x; beyond it by ratios j_n/j_{n-1} found downwards, where no
    // j_n is zero.
    Eigen::VectorXd ratio(degree + 1);
    double r = 0;
    for (int n = int(std::max(double(degree), x) + 6 * std::cbrt(x) + 24); n > 0; --n) {
        r = 1 / ((2 * n + 1) / x - r);
        if (n <= degree) ratio[n] = r;
    }
    j[0] = std::sin(x) / x;
    for (int n = 1; n <= degree; ++n)
        j[n] = n > x    ? ratio[n] * j[n - 1]
               : n == 1 ? (j[0] - std::cos(x)) / x
                        : (2 * n - 1) / x * j[n - 1] - j[n - 2];
    return j;
}

Eigen::VectorXd SphericalBesselY(int degree, double x) {
    LACQUER_CHECK(x > 0);
    Eigen::VectorXd y(degree + 1);
    y[0] = -std::cos(x) / x;
    if (degree >= 1) y[1] = (y[0] - std::sin(x)) / x;
    for (int n = 1; n < degree; ++n) y[n + 1] = (2 * n + 1) / x * y[n] - y[n - 1];
    return y;
}

Eigen::Vector3cd FieldAt(const Eigen::VectorXcd& coefficients, int degree, const Point& point,
                         bool isRegular) {
    const double r = point.norm();
    const Direction s{std::atan2(std::hypot(point.x(), point.y()), point.z()),
                      std::atan2(point.y(), point.x())};
    Eigen::VectorXcd z = SphericalBesselJ(degree + 1, r).cast<Complex>();
    if (!isRegular) z += Complex(0, 1) * SphericalBesselY(degree + 1, r).cast<Complex>();
    const VectorHarmonics h = HarmonicsAt(degree, s);
    const WignerD d(degree, s.theta, 0);
    const int size = NumHarmonics(degree);
    Complex radial = 0, alongTheta = 0, alongPhi = 0;
    for (int n = 1; n <= degree; ++n)
        for (int m = -n; m <= n; ++m) {
            const int row = HarmonicIndex(n, m);
            const Complex y = Normalization(n) * d.At(n, m, 0) * std::polar(1., m * s.phi);
            // N: z/r + z' = ((n+1) z_n/r - z_{n+1}) transverse, since z' = n z_n/r - z_{n+1}.
            const Complex transverse = (n + 1.) * z[n] / r - z[n + 1];
            const Complex magnetic = coefficients[row], electric = coefficients[size + row];
            radial += electric * std::sqrt(n * (n + 1.)) * z[n] / r * y;
            alongTheta += magnetic * z[n] * h.c(row, 0) + electric * transverse * h.b(row, 0);
            alongPhi += magnetic * z[n] * h.c(row, 1) + electric * transverse * h.b(row, 1);
        }
    const Point theta = Direction{s.theta + std::numbers::pi / 2, s.phi}.Vector();
    const Point phi(-std::sin(s.phi), std::cos(s.phi), 0);
    return radial * s.Vector().cast<Complex>() + alongTheta * theta.cast<Complex>() +
           alongPhi * phi.cast<Complex>();
}

}  // namespace lacquer::bulk
