// A simulator that costs nothing and whose likelihood is known in closed form.
#pragma once

#include <fmt/format.h>

#include <cmath>

#include "estimate/infer/target.h"
#include "estimate/random.h"
#include "estimate/simulator.h"

namespace lacquer::test {

/// Six summaries of two parameters with logits y: linear and, times `curvature`, quadratic in y; normal
/// scatter, correlated between neighbours, whose logarithm is linear in y with the slope `fanning`.
class AnalyticSimulator final : public estimate::Simulator {
  public:
    AnalyticSimulator(double curvature, double fanning)
        : curvature_(curvature),
          fanning_(fanning),
          space_({{"a", "", {0.4, 0.3, 0, 1}}, {"b", "cm", {5, 4, 1, 11}}}),
          names_(kCount, "summary") {
        for (int i = 0; i < kCount; ++i) names_[size_t(i)] += fmt::format(" {}", i);
    }
    const estimate::ParameterSpace& Parameters() const override { return space_; }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    estimate::Vector Simulate(const estimate::Vector& x, uint64_t seed) const override {
        const estimate::Vector y = space_.ToLogit(x);
        const estimate::Vector xi = estimate::Random(seed).Normals(kCount + 1);
        // Each neighbour shares half of its variance.
        return Mean(y) + Sd(y) * std::sqrt(0.5) * (xi.head(kCount) + xi.tail(kCount));
    }
    estimate::Vector Mean(const estimate::Vector& y) const {
        estimate::Vector mean(kCount);
        for (int i = 0; i < kCount; ++i)
            mean[i] = std::cos(i) * y[0] + std::sin(2 * i) * y[1] +
                      curvature_ * (std::sin(i) * y[0] * y[0] + std::cos(3 * i) * y[0] * y[1]);
        return mean;
    }
    double Sd(const estimate::Vector& y) const { return 0.6 * std::exp(fanning_ * (y[0] - 0.5 * y[1])); }
    static estimate::Matrix Correlations() {
        estimate::Matrix c = estimate::Matrix::Identity(kCount, kCount);
        for (int i = 0; i + 1 < kCount; ++i) c(i, i + 1) = c(i + 1, i) = 0.5;
        return c;
    }

    static constexpr int kCount = 6;

  private:
    double curvature_, fanning_;
    estimate::ParameterSpace space_;
    std::vector<std::string> names_;
};

/// Its exact posterior.
class AnalyticPosterior final : public estimate::Target {
  public:
    AnalyticPosterior(const AnalyticSimulator& simulator, estimate::Vector observed)
        : simulator_(simulator),
          observed_(std::move(observed)),
          precision_(AnalyticSimulator::Correlations().inverse()) {}
    Eigen::Index Size() const override { return 2; }
    /// Covariance times this: other than 1, a wrong one.
    double inflation = 1;
    double LogDensity(const estimate::Vector& y, estimate::Vector* gradient) const override {
        if (gradient) {
            // By differences: exact enough for a test's chains.
            gradient->resize(2);
            for (Eigen::Index i = 0; i < 2; ++i) {
                estimate::Vector high = y, low = y;
                high[i] += 1e-5;
                low[i] -= 1e-5;
                (*gradient)[i] = (LogDensity(high, nullptr) - LogDensity(low, nullptr)) / 2e-5;
            }
        }
        const estimate::Vector u = (observed_ - simulator_.Mean(y)) / simulator_.Sd(y);
        return simulator_.Parameters().LogPriorOfLogit(y) - 0.5 * u.dot(precision_ * u) / inflation -
               AnalyticSimulator::kCount * std::log(simulator_.Sd(y));
    }

  private:
    const AnalyticSimulator& simulator_;
    estimate::Vector observed_;
    estimate::Matrix precision_;
};

}  // namespace lacquer::test
