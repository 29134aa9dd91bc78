#include "estimate/mode/emulated_mode.h"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <cmath>
#include <limits>

namespace lacquer::estimate {

namespace {

/// Minus the logarithm of the density of natural parameters, as a function of logits.
class Descent final : public ceres::FirstOrderFunction {
  public:
    Descent(const ParameterSpace& space, const Target& target) : space_(space), target_(target) {}
    int NumParameters() const override { return int(target_.Size()); }
    bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
        const Vector y = Eigen::Map<const Vector>(parameters, target_.Size());
        Vector slope;
        const double value = target_.LogDensity(y, gradient ? &slope : nullptr);
        if (!std::isfinite(value)) return false;
        const Vector dxdy = space_.Slopes(y);
        *cost = dxdy.array().log().sum() - value;
        // d/dy log(dx/dy) = 1 - 2 s for the logistic function s.
        if (gradient) {
            const Vector s = (1 + (-y.array()).exp()).inverse().matrix();
            Eigen::Map<Vector>(gradient, y.size()) = (1 - 2 * s.array()).matrix() - slope;
        }
        return true;
    }

  private:
    const ParameterSpace& space_;
    const Target& target_;
};

}  // namespace

Vector FindMode(const ParameterSpace& space, const Target& target, const Matrix& starts) {
    ceres::GradientProblem problem(new Descent(space, target));
    ceres::GradientProblemSolver::Options options;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 500;
    double best = std::numeric_limits<double>::infinity();
    Vector mode = starts.col(0);
    for (Eigen::Index i = 0; i < starts.cols(); ++i) {
        Vector y = starts.col(i);
        ceres::GradientProblemSolver::Summary summary;
        ceres::Solve(options, problem, y.data(), &summary);
        if (summary.IsSolutionUsable() && summary.final_cost < best) {
            best = summary.final_cost;
            mode = y;
        }
    }
    return space.ToNatural(mode);
}

}  // namespace lacquer::estimate
