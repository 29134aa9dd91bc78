#include "estimate/emulator/regression_coordinates.h"

#include <algorithm>
#include <cmath>

namespace lacquer::estimate {

// An interval in the upper tail, where differences of probabilities would cancel, is mirrored.
NormalScore::NormalScore(const TruncatedNormal& d)
    : mean_(d.mean), sd_(d.sd), sign_(d.low > d.mean ? -1 : 1) {
    below_ = NormalCdf(sign_ * ((sign_ > 0 ? d.low : d.high) - mean_) / sd_);
    mass_ = d.Mass();
}

double NormalScore::Of(double x, double* slope) const {
    constexpr double kMinRank = 1e-12;
    const double z = sign_ * (x - mean_) / sd_;
    const double score = NormalQuantile(std::clamp((NormalCdf(z) - below_) / mass_, kMinRank, 1 - kMinRank));
    if (slope) *slope = std::exp(0.5 * (score * score - z * z)) / (sd_ * mass_);
    return sign_ * score;
}

RegressionCoordinates::RegressionCoordinates(const ParameterSpace& space) : space_(space) {
    for (const Parameter& parameter : space.All()) {
        const auto scale = space.Find(parameter.productWith);
        scores_.emplace_back(parameter.prior);
        scales_.push_back(scale ? Eigen::Index(*scale) : -1);
    }
}

Matrix RegressionCoordinates::FromLogits(const Matrix& y) const {
    Matrix t(y.rows(), y.cols());
    for (Eigen::Index column = 0; column < y.cols(); ++column) {
        const Vector x = space_.ToNatural(y.col(column));
        for (Eigen::Index i = 0; i < x.size(); ++i) {
            const Eigen::Index scale = scales_[size_t(i)];
            t(i, column) = scale < 0 ? scores_[size_t(i)].Of(x[i]) : std::sqrt(x[i] * x[scale]);
        }
    }
    return t;
}

Vector RegressionCoordinates::GradientByLogits(const Vector& y, const Vector& byCoordinates) const {
    const Vector x = space_.ToNatural(y), slopes = space_.Slopes(y);
    Vector gradient = Vector::Zero(y.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
        const Eigen::Index scale = scales_[size_t(i)];
        if (scale < 0) {
            double slope = 0;
            scores_[size_t(i)].Of(x[i], &slope);
            gradient[i] += byCoordinates[i] * slope * slopes[i];
        } else {
            const double by = 0.5 * byCoordinates[i] / std::sqrt(x[i] * x[scale]);
            gradient[i] += by * x[scale] * slopes[i];
            gradient[scale] += by * x[i] * slopes[scale];
        }
    }
    return gradient;
}

}  // namespace lacquer::estimate
