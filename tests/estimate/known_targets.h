// Targets whose distribution is known in closed form.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "estimate/infer/target.h"
#include "estimate/normal_distribution.h"

namespace lacquer::test {

/// Mixture of five normals with overlapping tails, cut to [-1, 1], in one dimension.
class FiveModes final : public estimate::Target {
  public:
    Eigen::Index Size() const override { return 1; }
    double LogDensity(const estimate::Vector& y, estimate::Vector* gradient) const override {
        double density = 0, slope = 0;
        for (int i = 0; i < 5; ++i) {
            const double z = (y[0] - kMeans[i]) / kSds[i], part = std::exp(-0.5 * z * z) / kSds[i];
            density += part;
            slope -= part * z / kSds[i];
        }
        if (gradient) *gradient = estimate::Vector::Constant(1, slope / (density + 1e-300));
        if (!(std::abs(y[0]) <= 1)) return -std::numeric_limits<double>::infinity();
        return std::log(density + 1e-300);
    }
    /// Half the sum of the differences of the parts of draws in 40 bins from the true ones.
    static double TotalVariation(const std::vector<double>& draws) {
        constexpr int kBins = 40;
        double counts[kBins] = {}, masses[kBins] = {}, total = 0, distance = 0;
        for (const double y : draws) ++counts[std::clamp(int((y + 1) / 2 * kBins), 0, kBins - 1)];
        for (int b = 0; b < kBins; ++b)
            for (int i = 0; i < 5; ++i) {
                const double low = -1 + 2. * b / kBins, high = low + 2. / kBins;
                masses[b] += estimate::NormalCdf((high - kMeans[i]) / kSds[i]) -
                             estimate::NormalCdf((low - kMeans[i]) / kSds[i]);
            }
        for (const double mass : masses) total += mass;
        for (int b = 0; b < kBins; ++b)
            distance += std::abs(counts[b] / double(draws.size()) - masses[b] / total);
        return distance / 2;
    }

  private:
    static constexpr double kMeans[5] = {-0.8, -0.4, 0, 0.4, 0.8}, kSds[5] = {0.06, 0.08, 0.1, 0.12, 0.14};
};

/// A normal distribution.
class NormalTarget final : public estimate::Target {
  public:
    NormalTarget(estimate::Vector mean, const estimate::Matrix& covariance)
        : mean_(std::move(mean)),
          precision_(
              covariance.llt().solve(estimate::Matrix::Identity(covariance.rows(), covariance.cols()))) {}
    /// Adds this to the logarithm of the density, which is a constant to the sampler of one target.
    double offset = 0;
    Eigen::Index Size() const override { return mean_.size(); }
    double LogDensity(const estimate::Vector& y, estimate::Vector* gradient) const override {
        const estimate::Vector pull = precision_ * (y - mean_);
        if (gradient) *gradient = -pull;
        return offset - 0.5 * pull.dot(y - mean_);
    }

  private:
    estimate::Vector mean_;
    estimate::Matrix precision_;
};

/// Standard deviations 1 and .05, correlation .9.
inline NormalTarget CorrelatedNormal() {
    Eigen::Matrix2d covariance;
    covariance << 1, 0.9 * 0.05, 0.9 * 0.05, 0.0025;
    return {Eigen::Vector2d::Zero(), covariance};
}

}  // namespace lacquer::test
