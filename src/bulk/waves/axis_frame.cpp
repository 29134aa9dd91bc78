#include "bulk/waves/axis_frame.h"

#include <cmath>

namespace lacquer::bulk {
namespace {

double PolarAngle(const Point& d) { return std::atan2(std::hypot(d.x(), d.y()), d.z()); }

}  // namespace

AxisFrame::AxisFrame(const Point& axis, int degree, int maxOrder)
    : phi_(std::atan2(axis.y(), axis.x())), d_(degree, PolarAngle(axis), maxOrder) {}

// c'_k = sum_m e^{i m phi} d^n_{mk} c_m, for the orders k that pass.
Eigen::MatrixXcd AxisFrame::Into(const Eigen::MatrixXcd& coefficients, int degree) const {
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

Eigen::MatrixXcd AxisFrame::OutOf(const Eigen::MatrixXcd& coefficients, int degree) const {
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

}  // namespace lacquer::bulk
