#include "bulk/waves/translation.h"

#include <algorithm>
#include <cmath>

#include "bulk/waves/axial_translation.h"
#include "bulk/waves/harmonics.h"
#include "bulk/waves/helicity_orders.h"

namespace lacquer::bulk {

Translation::Translation(const Point& d, int fromDegree, int toDegree)
    : fromDegree_(fromDegree),
      toDegree_(toDegree),
      maxOrder_(std::min(fromDegree, toDegree)),
      frame_(d, std::max(fromDegree, toDegree), maxOrder_) {
    AxialTranslation axial(fromDegree, toDegree);
    const double kd = d.norm();
    const int numBessel = axial.NumBessel();
    const Eigen::VectorXd besselJ = SphericalBesselJ(numBessel - 1, kd);
    const Eigen::VectorXd besselY = SphericalBesselY(numBessel - 1, kd);
    std::vector<Lanes> j(size_t(numBessel), Lanes{}), y(size_t(numBessel), Lanes{});
    for (int nu = 0; nu < numBessel; ++nu) {
        j[size_t(nu)][0] = besselJ[nu];
        y[size_t(nu)][0] = besselY[nu];
    }
    Lanes lanes{};
    lanes[0] = kd;
    axial.Compute(lanes, j.data(), y.data());
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

Eigen::MatrixXcd Translation::Apply(const Eigen::MatrixXcd& coefficients) const {
    const auto shift = [&](int m, const Eigen::MatrixXcd& waves) -> Eigen::MatrixXcd {
        return shifts_[size_t(m + maxOrder_)] * waves;
    };
    return frame_.OutOf(
        ForHelicityOrders(frame_.Into(coefficients, fromDegree_), fromDegree_, toDegree_, shift), toDegree_);
}

Eigen::MatrixXcd Translation::Matrix() const {
    const int columns = 2 * NumHarmonics(fromDegree_);
    return Apply(Eigen::MatrixXcd::Identity(columns, columns));
}

}  // namespace lacquer::bulk
