#include "estimate/mode/find_modes.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "estimate/random.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// All residuals in one block, their Jacobian by central differences.
class ModeResiduals final : public ceres::CostFunction {
  public:
    ModeResiduals(const FixedSeedTarget& target, double difference)
        : target_(target), difference_(difference) {
        mutable_parameter_block_sizes()->push_back(int(target.Size()));
        set_num_residuals(int(target.NumSummaries() + target.Size()));
    }
    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
        const Vector y = Eigen::Map<const Vector>(parameters[0], target_.Size());
        Eigen::Map<Vector>(residuals, num_residuals()) = target_.Residuals(y);
        if (!jacobians || !jacobians[0]) return true;
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
            jacobians[0], num_residuals(), target_.Size());
        Matrix sides(num_residuals(), 2 * target_.Size());
        ParallelFor(sides.cols(), [&](int64_t i) {
            Vector moved = y;
            moved[i / 2] += i % 2 ? difference_ : -difference_;
            sides.col(i) = target_.Residuals(moved);
        });
        for (Eigen::Index i = 0; i < target_.Size(); ++i)
            jacobian.col(i) = (sides.col(2 * i + 1) - sides.col(2 * i)) / (2 * difference_);
        return true;
    }

  private:
    const FixedSeedTarget& target_;
    double difference_;
};

/// Draws of the prior with the least energy.
std::vector<Vector> BestDraws(const FixedSeedTarget& target, const ModeOptions& options) {
    const ParameterSpace& space = target.Model().Parameters();
    std::vector<Vector> draws(size_t(options.numDraws));
    std::vector<double> energies(draws.size());
    ParallelFor(options.numDraws, [&](int64_t i) {
        Random random(options.seed, uint64_t(i));
        draws[size_t(i)] = space.ToLogit(space.SamplePrior(random));
        energies[size_t(i)] = target.Energy(draws[size_t(i)], nullptr);
    });
    std::vector<size_t> order(draws.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return energies[a] < energies[b]; });
    std::vector<Vector> best;
    for (size_t i = 0; i < std::min(order.size(), size_t(options.numStarts)); ++i)
        best.push_back(draws[order[i]]);
    return best;
}

/// The best point that Adam's steps come by.
Vector Descend(const FixedSeedTarget& target, Vector y, const ModeOptions& options, Observer* observer) {
    constexpr double kBeta1 = 0.9, kBeta2 = 0.99;
    Vector mean = Vector::Zero(y.size()), squares = mean, best = y;
    double least = std::numeric_limits<double>::infinity();
    for (int step = 1; step <= options.adamSteps && !(observer && observer->ShouldStop()); ++step) {
        Vector gradient;
        const double energy = target.Energy(y, &gradient);
        if (energy < least) {
            least = energy;
            best = y;
        }
        mean = kBeta1 * mean + (1 - kBeta1) * gradient;
        squares = kBeta2 * squares + (1 - kBeta2) * gradient.cwiseAbs2();
        const double part = double(step) / options.adamSteps;
        const double rate = options.firstRate * (1 - part) + options.lastRate * part;
        const Vector direction = (mean.array() / (1 - std::pow(kBeta1, step)) /
                                  ((squares.array() / (1 - std::pow(kBeta2, step))).sqrt() + 1e-9))
                                     .matrix();
        y -= rate * direction;
        if (observer) observer->Advance(1);
    }
    return best;
}

Vector Refine(const FixedSeedTarget& target, Vector y, const ModeOptions& options) {
    constexpr double kMaxLogit = 13.8;  // a part of 1e-6 from a bound
    ceres::Problem problem;
    problem.AddResidualBlock(new ModeResiduals(target, options.difference), nullptr, y.data());
    for (int i = 0; i < int(y.size()); ++i) {
        y[i] = std::clamp(y[i], -kMaxLogit, kMaxLogit);
        problem.SetParameterLowerBound(y.data(), i, -kMaxLogit);
        problem.SetParameterUpperBound(y.data(), i, kMaxLogit);
    }
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_QR;
    solver.max_num_iterations = options.maxIterations;
    solver.function_tolerance = 1e-8;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    return y;
}

}  // namespace

Matrix CovarianceAt(const FixedSeedTarget& target, const Vector& y) {
    const ModeResiduals residuals(target, ModeOptions().difference);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(residuals.num_residuals(),
                                                                                    y.size());
    Vector values(residuals.num_residuals());
    const double* parameters = y.data();
    double* derivatives = jacobian.data();
    residuals.Evaluate(&parameters, values.data(), &derivatives);
    const Matrix information = jacobian.transpose() * jacobian;
    // A parameter at its bound has no derivatives: its prior's would then be all.
    const Matrix ridge = 1e-2 * Matrix::Identity(y.size(), y.size());
    return (information + ridge).llt().solve(Matrix::Identity(y.size(), y.size()));
}

std::vector<Mode> FindModes(const FixedSeedTarget& target, const ModeOptions& options, Observer* observer) {
    const bool hasGradient = target.HasGradient();
    std::vector<Mode> modes;
    for (Vector y : BestDraws(target, options)) {
        if (hasGradient) y = Descend(target, std::move(y), options, observer);
        y = Refine(target, std::move(y), options);
        const double energy = target.Energy(y, nullptr);
        modes.push_back({std::move(y), energy, 0});
    }
    std::stable_sort(modes.begin(), modes.end(),
                     [](const Mode& a, const Mode& b) { return a.energy < b.energy; });
    std::vector<Mode> kept;
    for (Mode& mode : modes) {
        const bool isElsewhere = std::all_of(kept.begin(), kept.end(), [&](const Mode& other) {
            return (other.y - mode.y).cwiseAbs().maxCoeff() > 0.05;
        });
        if (!isElsewhere || mode.energy > modes.front().energy + 2) continue;
        mode.misfit = target.Misfit(mode.y) / double(target.NumSummaries());
        kept.push_back(mode);
    }
    return kept;
}

}  // namespace lacquer::estimate
