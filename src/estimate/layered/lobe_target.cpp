#include "estimate/layered/lobe_target.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimate/infer/population.h"

namespace lacquer::estimate {

namespace {

/// Beyond such logits a parameter is at its bound, and nothing changes any more.
constexpr double kMaxLogit = 25;

bool IsOutside(const Vector& y) { return !(y.cwiseAbs().maxCoeff() < kMaxLogit); }

PredictionError ErrorOf(const LobeEmulator& emulator, const Vector& variances, double scale) {
    return {scale * scale * emulator.Remainder(),
            emulator.Components() * (scale * variances.cwiseSqrt()).asDiagonal()};
}

}  // namespace

ParameterSpace WithNoise(const ParameterSpace& ofModel, const Prior& ofNoise) {
    std::vector<Parameter> parameters = ofModel.All();
    parameters.push_back({.name = kNoiseName, .unit = "", .prior = ofNoise});
    return ParameterSpace(std::move(parameters));
}

SimulatedRegion::SimulatedRegion(const Matrix& points) : center_(points.rowwise().mean()) {
    constexpr double kSlack = 1.2;
    const Matrix factor = CholeskyFactor(CovarianceOfColumns(points));
    whitening_ = factor.triangularView<Eigen::Lower>().solve(Matrix::Identity(factor.rows(), factor.cols()));
    for (Eigen::Index i = 0; i < points.cols(); ++i)
        squaredRadius_ = std::max(squaredRadius_, kSlack * SquaredDistance(points.col(i)));
}

double SimulatedRegion::Log(const Vector& point, Vector* gradient) const {
    const Vector t = whitening_ * (point - center_);
    const double outside = std::max(0., t.squaredNorm() - squaredRadius_);
    if (gradient) *gradient = outside > 0 ? Vector(-2 * whitening_.transpose() * t) : Vector::Zero(t.size());
    return -outside;
}

LobeTarget::LobeTarget(const ParameterSpace& space, const LobeCoordinates& coordinates,
                       std::shared_ptr<const LobeEmulator> emulator, const Vector& variances,
                       const ObservedLobes& observed, SimulatedRegion region, bool isRobust,
                       double errorScale)
    : space_(space),
      coordinates_(coordinates),
      emulator_(std::move(emulator)),
      likelihood_(observed.logs, observed.deviations, ErrorOf(*emulator_, variances, errorScale), isRobust),
      region_(std::move(region)) {}

double LobeTarget::LogDensity(const Vector& y, Vector* gradient) const {
    if (IsOutside(y)) return -std::numeric_limits<double>::infinity();
    const Vector x = space_.ToNatural(y), point = coordinates_.FromNatural(x);
    const Eigen::Index d = coordinates_.Size();
    Matrix derivatives;
    Vector byMean, byRegion;
    double byNoise = 0;
    const Vector coefficients = emulator_->Coefficients(point, gradient ? &derivatives : nullptr);
    double value = likelihood_.Log(emulator_->Values(coefficients), x[d], gradient ? &byMean : nullptr,
                                   gradient ? &byNoise : nullptr);
    value += region_.Log(point, gradient ? &byRegion : nullptr);
    value += space_.LogPriorOfLogit(y, gradient);
    if (gradient) {
        const Vector byPoint =
            derivatives.transpose() * (emulator_->Components().transpose() * byMean) + byRegion;
        Vector byNatural(d + 1);
        byNatural << coordinates_.GradientByNatural(x, byPoint), byNoise;
        *gradient += byNatural.cwiseProduct(space_.Slopes(y));
    }
    return value;
}

ExactLobeTarget::ExactLobeTarget(const Simulator& simulator, const ParameterSpace& space,
                                 const ObservedLobes& observed, bool isRobust, const Target* guide)
    : simulator_(simulator),
      space_(space),
      likelihood_(observed.logs, observed.deviations,
                  {Vector::Zero(observed.logs.size()), Matrix(observed.logs.size(), 0)}, isRobust),
      floor_(observed.floor),
      guide_(guide) {}

Vector ExactLobeTarget::Predict(const Vector& x) const {
    const Vector all = simulator_.Simulate(x.head(x.size() - 1), 0);
    return FlooredLogs(all.head(all.size() / 2), floor_);
}

double ExactLobeTarget::LogDensity(const Vector& y, Vector* gradient) const {
    // In logits; models compute in single precision.
    constexpr double kStep = 1e-2;
    if (IsOutside(y)) return -std::numeric_limits<double>::infinity();
    const Vector x = space_.ToNatural(y);
    const Eigen::Index noise = x.size() - 1;
    if (guide_ && gradient) {
        guide_->LogDensity(y, gradient);
        gradient = nullptr;
    }
    Vector byMean;
    double byNoise = 0;
    double value =
        likelihood_.Log(Predict(x), x[noise], gradient ? &byMean : nullptr, gradient ? &byNoise : nullptr);
    value += space_.LogPriorOfLogit(y, gradient);
    if (!gradient) return value;
    for (Eigen::Index i = 0; i < noise; ++i) {
        Vector above = y, below = y;
        above[i] += kStep;
        below[i] -= kStep;
        const Vector change = Predict(space_.ToNatural(above)) - Predict(space_.ToNatural(below));
        (*gradient)[i] += byMean.dot(change) / (2 * kStep);
    }
    (*gradient)[noise] += byNoise * space_.Slopes(y)[noise];
    return value;
}

}  // namespace lacquer::estimate
