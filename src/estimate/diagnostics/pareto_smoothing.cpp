#include "estimate/diagnostics/pareto_smoothing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace lacquer::estimate {

double GeneralizedPareto::Quantile(double p) const {
    return std::abs(k) < 1e-12 ? -sigma * std::log1p(-p) : sigma * std::expm1(-k * std::log1p(-p)) / k;
}

GeneralizedPareto FitGeneralizedPareto(const std::vector<double>& exceedances) {
    // Mean of theta = -k / sigma over its profile likelihood times a prior that the data scale, on a grid.
    const size_t n = exceedances.size(), gridSize = 30 + size_t(std::sqrt(double(n)));
    const double quarter = exceedances[size_t(double(n) / 4 + 0.5) - 1], largest = exceedances.back();
    const auto shapeAt = [&](double theta) {
        double sum = 0;
        for (const double x : exceedances) sum += std::log1p(-theta * x);
        return sum / double(n);
    };
    std::vector<double> thetas(gridSize), logLikelihoods(gridSize);
    for (size_t i = 0; i < gridSize; ++i) {
        const double part = std::sqrt(double(gridSize) / (double(i) + 0.5));
        thetas[i] = 1 / largest + (1 - part) / (3 * quarter);
        const double shape = shapeAt(thetas[i]);
        logLikelihoods[i] = double(n) * (std::log(-thetas[i] / shape) - shape - 1);
    }
    const double best = *std::max_element(logLikelihoods.begin(), logLikelihoods.end());
    double weightSum = 0, theta = 0;
    for (size_t i = 0; i < gridSize; ++i) {
        const double weight = std::exp(logLikelihoods[i] - best);
        weightSum += weight;
        theta += weight * thetas[i];
    }
    theta /= weightSum;
    const double k = shapeAt(theta);
    return {k, -k / theta};
}

SmoothedWeights ParetoSmooth(const std::vector<double>& logWeights) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    const size_t count = logWeights.size();
    const double most = count > 0 ? *std::max_element(logWeights.begin(), logWeights.end()) : -kInf;
    SmoothedWeights result{std::vector<double>(count, 0), kInf};
    if (!std::isfinite(most)) return result;
    for (size_t i = 0; i < count; ++i) result.weights[i] = std::exp(logWeights[i] - most);

    std::vector<size_t> order(count);
    std::iota(order.begin(), order.end(), size_t(0));
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return logWeights[a] < logWeights[b]; });
    const auto tail = size_t(std::ceil(std::min(0.2 * double(count), 3 * std::sqrt(double(count)))));
    const double cut = tail < count ? result.weights[order[count - tail - 1]] : 0;
    std::vector<double> exceedances;
    for (size_t i = count - tail; i < count; ++i)
        if (result.weights[order[i]] > cut) exceedances.push_back(result.weights[order[i]] - cut);
    if (exceedances.size() >= 5 && exceedances.back() > exceedances.front()) {
        GeneralizedPareto fit = FitGeneralizedPareto(exceedances);
        // A weak prior of ten observations with k = 1/2 steadies short tails.
        const auto n = double(exceedances.size());
        fit.k = (fit.k * n + 0.5 * 10) / (n + 10);
        result.k = fit.k;
        for (size_t i = 0; i < exceedances.size(); ++i) {
            const double smoothed = cut + fit.Quantile((double(i) + 0.5) / n);
            result.weights[order[count - exceedances.size() + i]] = std::min(smoothed, 1.);
        }
    }
    const double sum = std::accumulate(result.weights.begin(), result.weights.end(), 0.);
    for (double& weight : result.weights) weight /= sum;
    return result;
}

}  // namespace lacquer::estimate
