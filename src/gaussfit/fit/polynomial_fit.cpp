#include "gaussfit/fit/polynomial_fit.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lacquer::gaussfit {

namespace {

/// All residuals of one problem in one block: data first, then the differences of neighbours.
class Residuals final : public ceres::CostFunction {
  public:
    explicit Residuals(const PolynomialFitProblem& problem) : p_(problem) {
        mutable_parameter_block_sizes()->push_back(p_.basis->columns);
        set_num_residuals(p_.basis->Rows() + int(p_.neighbors.size()));
    }

    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
        const double* control = parameters[0];
        double* jacobian = jacobians ? jacobians[0] : nullptr;
        const int rows = p_.basis->Rows(), columns = p_.basis->columns;
        if (jacobian) std::fill_n(jacobian, size_t(num_residuals()) * size_t(columns), 0.0);
        for (int i = 0; i < rows; ++i) {
            const double* row = p_.basis->Row(i);
            double value = 0;
            for (int k = 0; k < columns; ++k) value += row[k] * control[k];
            const double weight = p_.weights[size_t(i)], target = p_.targets[size_t(i)];
            residuals[i] = weight * ((p_.isLogarithmic ? std::log(value) : value) - target);
            if (!jacobian) continue;
            const double slope = p_.isLogarithmic ? weight / value : weight;
            for (int k = 0; k < columns; ++k)
                jacobian[size_t(i) * size_t(columns) + size_t(k)] = slope * row[k];
        }
        for (size_t i = 0; i < p_.neighbors.size(); ++i) {
            const int a = p_.neighbors[i][0], b = p_.neighbors[i][1];
            residuals[size_t(rows) + i] = p_.smoothing * (control[a] - control[b]);
            if (!jacobian) continue;
            double* out = jacobian + (size_t(rows) + i) * size_t(columns);
            out[a] = p_.smoothing;
            out[b] = -p_.smoothing;
        }
        return true;
    }

  private:
    const PolynomialFitProblem& p_;
};

}  // namespace

void FitPolynomial(const PolynomialFitProblem& problem, std::vector<double>* control) {
    for (double& value : *control) value = std::clamp(value, problem.lower, problem.upper);
    ceres::Problem ceresProblem;
    ceresProblem.AddResidualBlock(new Residuals(problem), nullptr, control->data());
    for (int i = 0; i < problem.basis->columns; ++i) {
        if (problem.lower > -1e30) ceresProblem.SetParameterLowerBound(control->data(), i, problem.lower);
        if (problem.upper < 1e30) ceresProblem.SetParameterUpperBound(control->data(), i, problem.upper);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = problem.maxIterations;
    options.function_tolerance = 1e-8;
    options.num_threads = 1;  // several problems are solved at once
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceresProblem, &summary);
    if (!summary.IsSolutionUsable()) throw std::runtime_error("a fit of lobes failed: " + summary.message);
}

}  // namespace lacquer::gaussfit
