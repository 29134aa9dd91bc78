#include "bulk/waves/regular_translation.h"

#include <algorithm>
#include <cmath>

#include "bulk/mie/mie.h"
#include "bulk/waves/axis_frame.h"
#include "bulk/waves/harmonics.h"
#include "bulk/waves/helicity_orders.h"
#include "bulk/waves/wigner.h"
#include "pbrt/core/check.h"
#include "pbrt/core/quadrature.h"

namespace lacquer::bulk {

RegularTranslation::RegularTranslation(int fromDegree, int toDegree, double maxDistance)
    : fromDegree_(fromDegree),
      toDegree_(toDegree),
      maxOrder_(std::min(fromDegree, toDegree)),
      maxDistance_(maxDistance) {
    LACQUER_CHECK(fromDegree >= 1 && toDegree >= 1);
    constexpr double kDigits = 15;
    const int degree = std::max(fromDegree, toDegree);
    const std::vector<QuadratureNode> rule =
        GaussLegendre((fromDegree + toDegree + FieldDegree(maxDistance, kDigits)) / 2 + 1);
    const Eigen::Index numNodes = Eigen::Index(rule.size());
    for (int m = -maxOrder_; m <= maxOrder_; ++m)
        planeWaves_.emplace_back(degree - std::max(1, std::abs(m)) + 1, numNodes);
    for (Eigen::Index node = 0; node < numNodes; ++node) {
        const QuadratureNode& q = rule[size_t(node)];
        cosines_.push_back(q.x);
        const WignerD d(degree, std::acos(q.x), 1);
        for (int m = -maxOrder_; m <= maxOrder_; ++m) {
            const int lo = std::max(1, std::abs(m));
            for (int n = lo; n <= degree; ++n)
                planeWaves_[size_t(m + maxOrder_)](n - lo, node) =
                    std::sqrt((n + 0.5) * q.weight) * d.At(n, m, 1);
        }
    }
}

Eigen::MatrixXcd RegularTranslation::Apply(const Point& d, const Eigen::MatrixXcd& coefficients) const {
    const double kd = d.norm();
    LACQUER_CHECK(kd <= maxDistance_ * (1 + 1e-12));
    Eigen::VectorXcd phases(Eigen::Index(cosines_.size()));
    for (size_t node = 0; node < cosines_.size(); ++node)
        phases[Eigen::Index(node)] = std::polar(1., kd * cosines_[node]);
    const auto shift = [&](int m, Eigen::MatrixXcd waves) -> Eigen::MatrixXcd {
        const int lo = std::max(1, std::abs(m));
        const Eigen::MatrixXd& planeWaves = planeWaves_[size_t(m + maxOrder_)];
        const auto from = planeWaves.topRows(fromDegree_ - lo + 1);
        const auto to = planeWaves.topRows(toDegree_ - lo + 1);
        for (int n = lo; n <= fromDegree_; ++n) waves.row(n - lo) *= PowerOfI(-n);
        // Products of real matrices are faster than mixed ones.
        Eigen::MatrixXcd spectrum(from.cols(), waves.cols());
        spectrum.real() = from.transpose() * waves.real();
        spectrum.imag() = from.transpose() * waves.imag();
        spectrum = phases.asDiagonal() * spectrum;
        Eigen::MatrixXcd shifted(to.rows(), waves.cols());
        shifted.real() = to * spectrum.real();
        shifted.imag() = to * spectrum.imag();
        for (int nu = lo; nu <= toDegree_; ++nu) shifted.row(nu - lo) *= PowerOfI(nu);
        return shifted;
    };
    const AxisFrame frame(d, std::max(fromDegree_, toDegree_), maxOrder_);
    return frame.OutOf(
        ForHelicityOrders(frame.Into(coefficients, fromDegree_), fromDegree_, toDegree_, shift), toDegree_);
}

Eigen::MatrixXcd RegularTranslation::Matrix(const Point& d) const {
    const int columns = 2 * NumHarmonics(fromDegree_);
    return Apply(d, Eigen::MatrixXcd::Identity(columns, columns));
}

}  // namespace lacquer::bulk
