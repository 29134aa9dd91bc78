#include "bulk/waves/translation.h"

#include <cmath>

#include "bulk/waves/harmonics.h"

namespace lacquer::bulk {
namespace {

double PolarAngle(const Point& d) { return std::atan2(std::hypot(d.x(), d.y()), d.z()); }

}  // namespace

Translation::Translation(const Point& d, WaveKind kind, int fromDegree, int toDegree)
    : fromDegree_(fromDegree),
      toDegree_(toDegree),
      maxOrder_(std::min(fromDegree, toDegree)),
      phi_(std::atan2(d.y(), d.x())),
      d_(std::max(fromDegree, toDegree), PolarAngle(d), maxOrder_) {
    AxialTranslation axial(fromDegree, toDegree);
    const double kd = d.norm();
    const int numBessel = axial.NumBessel();
    std::vector<Lanes> j(size_t(numBessel), Lanes{}), y(size_t(numBessel), Lanes{});
    const Eigen::VectorXd besselJ = SphericalBesselJ(numBessel - 1, kd);
    for (int nu = 0; nu < numBessel; ++nu) j[size_t(nu)][0] = besselJ[nu];
    if (kind == WaveKind::Outgoing) {
        const Eigen::VectorXd besselY = SphericalBesselY(numBessel - 1, kd);
        for (int nu = 0; nu < numBessel; ++nu) y[size_t(nu)][0] = besselY[nu];
    }
    Lanes lanes{};
    lanes[0] = kd;
    axial.Compute(lanes, j.data(), kind == WaveKind::Outgoing ? y.data() : nullptr);
    for (int m = -maxOrder_; m <= maxOrder_; ++m) {
        const int lo = std::max(1, std::abs(m));
        Eigen::MatrixXcd shift(toDegree - lo + 1, fromDegree - lo + 1);
        for (int nu = lo; nu <= toDegree; ++nu)
            for (int n = lo; n <= fromDegree; ++n) {
                AxialTranslation::Entry e;
                axial.Get(std::abs(m), nu, n, &e);
                const Complex a(e.aReal[0], e.aImag[0]), b(-e.bImag[0], e.bReal[0]);
                shift(nu - lo, n - lo) = m >= 0 ? a + b : a - b;
            }
        shifts_.push_back(std::move(shift));
    }
}

// c'_k = sum_m e^{i m phi} d^n_{mk} c_m, for the orders k that pass.
Eigen::MatrixXcd Translation::IntoFrame(const Eigen::MatrixXcd& coefficients, int degree) const {
    const int size = NumHarmonics(degree);
    Eigen::MatrixXcd turned = Eigen::MatrixXcd::Zero(coefficients.rows(), coefficients.cols());
    for (int n = 1; n <= degree; ++n) {
        Eigen::MatrixXcd matrix = d_.Of(n).cast<Complex>();
        for (int m = -n; m <= n; ++m) matrix.row(m + n) *= std::polar(1., m * phi_);
        const int orders = d_.MaxOrder(n);
        for (const int part : {0, size})
            turned.middleRows(part + HarmonicIndex(n, -orders), 2 * orders + 1) =
                matrix.transpose() * coefficients.middleRows(part + HarmonicIndex(n, -n), 2 * n + 1);
    }
    return turned;
}

Eigen::MatrixXcd Translation::OutOfFrame(const Eigen::MatrixXcd& coefficients, int degree) const {
    const int size = NumHarmonics(degree);
    Eigen::MatrixXcd turned(coefficients.rows(), coefficients.cols());
    for (int n = 1; n <= degree; ++n) {
        Eigen::MatrixXcd matrix = d_.Of(n).cast<Complex>();
        for (int m = -n; m <= n; ++m) matrix.row(m + n) *= std::polar(1., -m * phi_);
        const int orders = d_.MaxOrder(n);
        for (const int part : {0, size})
            turned.middleRows(part + HarmonicIndex(n, -n), 2 * n + 1) =
                matrix * coefficients.middleRows(part + HarmonicIndex(n, -orders), 2 * orders + 1);
    }
    return turned;
}

namespace {

/// result = shift of `in`, order by order. In the helicity basis M + N and M - N the parts do not mix.
/// @param matrixOf  of an order and a helicity (0: M + N)
template <class MatrixOf>
Eigen::MatrixXcd ShiftOrders(const Eigen::MatrixXcd& in, int inDegree, int outDegree, int maxOrder,
                             const MatrixOf& matrixOf) {
    const int inSize = NumHarmonics(inDegree), outSize = NumHarmonics(outDegree);
    Eigen::MatrixXcd out = Eigen::MatrixXcd::Zero(2 * outSize, in.cols());
    for (int m = -maxOrder; m <= maxOrder; ++m) {
        const int lo = std::max(1, std::abs(m));
        for (const int helicity : {0, 1}) {
            Eigen::MatrixXcd waves(inDegree - lo + 1, in.cols());
            const double sign = helicity == 0 ? 1 : -1;
            for (int n = lo; n <= inDegree; ++n)
                waves.row(n - lo) =
                    0.5 * (in.row(HarmonicIndex(n, m)) + sign * in.row(inSize + HarmonicIndex(n, m)));
            const Eigen::MatrixXcd shifted = matrixOf(m, helicity) * waves;
            for (int nu = lo; nu <= outDegree; ++nu) {
                out.row(HarmonicIndex(nu, m)) += shifted.row(nu - lo);
                out.row(outSize + HarmonicIndex(nu, m)) += sign * shifted.row(nu - lo);
            }
        }
    }
    return out;
}

}  // namespace

Eigen::MatrixXcd Translation::Apply(const Eigen::MatrixXcd& coefficients) const {
    const auto matrixOf = [&](int m, int helicity) -> const Eigen::MatrixXcd& {
        return shifts_[size_t((helicity == 0 ? m : -m) + maxOrder_)];
    };
    return OutOfFrame(
        ShiftOrders(IntoFrame(coefficients, fromDegree_), fromDegree_, toDegree_, maxOrder_, matrixOf),
        toDegree_);
}

Eigen::MatrixXcd Translation::ApplyAdjoint(const Eigen::MatrixXcd& coefficients) const {
    const auto matrixOf = [&](int m, int helicity) -> Eigen::MatrixXcd {
        return shifts_[size_t((helicity == 0 ? m : -m) + maxOrder_)].adjoint();
    };
    return OutOfFrame(
        ShiftOrders(IntoFrame(coefficients, toDegree_), toDegree_, fromDegree_, maxOrder_, matrixOf),
        fromDegree_);
}

Eigen::MatrixXcd Translation::Matrix() const {
    const int columns = 2 * NumHarmonics(fromDegree_);
    return Apply(Eigen::MatrixXcd::Identity(columns, columns));
}

}  // namespace lacquer::bulk
