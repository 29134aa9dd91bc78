// Control values of one Bernstein polynomial in three variables by least squares; Ceres stays behind this
// header.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace lacquer::gaussfit {

/// Rows of a matrix: the values of all basis polynomials at one point.
struct BasisMatrix {
    int columns = 0;
    std::vector<double> values;
    int Rows() const { return int(values.size()) / columns; }
    const double* Row(int i) const { return values.data() + std::size_t(i) * std::size_t(columns); }
};

struct PolynomialFitProblem {
    const BasisMatrix* basis = nullptr;
    std::vector<double> targets, weights;  ///< of the rows; residual: weight (P - target)
    /// The residual is weight (log P - target) instead; the control values stay above `lower`, which is > 0
    /// then.
    bool isLogarithmic = false;
    double lower = -1e30, upper = 1e30;  ///< of the control values
    /// Neighbours along each axis that differ cost this much times their difference: it settles the control
    /// values that no data reach, and is small next to what data say.
    double smoothing = 0;
    std::vector<std::array<int, 2>> neighbors;  ///< pairs of control values, along all axes
    int maxIterations = 50;
};

/// Improves `control` (one value for each column) by Levenberg and Marquardt's method, within bounds.
/// Errors: std::runtime_error if the solver fails, which finite data do not make it do.
void FitPolynomial(const PolynomialFitProblem& problem, std::vector<double>* control);

}  // namespace lacquer::gaussfit
