#include "bulk/table/size_extrapolation.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::bulk {

ScatteringAverage::Value ExtrapolateInSize(std::span<const double> radii,
                                           std::span<const ScatteringAverage::Value> values) {
    LACQUER_CHECK(radii.size() >= 2 && values.size() == radii.size());
    double largestError = 0;
    for (const auto& value : values) largestError = std::max(largestError, value.error);
    // Values without an error, such as an absorption of 0, weigh the same.
    const auto weight = [&](const ScatteringAverage::Value& value) {
        return largestError > 0 ? std::pow(std::max(value.error, 1e-6 * largestError), -2) : 1.;
    };
    double sum = 0, x = 0, y = 0;
    for (size_t i = 0; i < radii.size(); ++i) {
        sum += weight(values[i]);
        x += weight(values[i]) / radii[i];
        y += weight(values[i]) * values[i].mean;
    }
    x /= sum;
    y /= sum;
    double xx = 0, xy = 0;
    for (size_t i = 0; i < radii.size(); ++i) {
        const double dx = 1 / radii[i] - x;
        xx += weight(values[i]) * dx * dx;
        xy += weight(values[i]) * dx * (values[i].mean - y);
    }
    const double slope = xy / xx;
    double chiSquare = 0;
    for (size_t i = 0; i < radii.size(); ++i) {
        const double rest = values[i].mean - y - slope * (1 / radii[i] - x);
        chiSquare += weight(values[i]) * rest * rest;
    }
    const double freedom = double(radii.size()) - 2;
    const double excess = freedom > 0 && largestError > 0 ? std::max(1., chiSquare / freedom) : 1;
    const double variance = largestError > 0 ? (1 / sum + x * x / xx) * excess : 0;
    return {y - slope * x, std::sqrt(variance)};
}

SizeResult ResultOf(const BulkComputation& computation, std::span<const BulkRow> rows) {
    SizeResult result{
        computation.Settings().ensemble.count, computation.GetEnsemble().BallRadius(), {}, {}, {}};
    for (const BulkRow& row : rows) {
        result.sigmaS.push_back(row.sigmaS);
        result.sigmaA.push_back(row.sigmaA);
        result.g.push_back(row.g);
    }
    return result;
}

SizeResult Extrapolate(std::span<const SizeResult> sizes) {
    SizeResult result;
    std::vector<double> radii;
    for (const SizeResult& size : sizes) radii.push_back(size.ballRadius);
    for (const auto quantity : {&SizeResult::sigmaS, &SizeResult::sigmaA, &SizeResult::g})
        for (size_t w = 0; w < (sizes[0].*quantity).size(); ++w) {
            std::vector<ScatteringAverage::Value> values;
            for (const SizeResult& size : sizes) values.push_back((size.*quantity)[w]);
            (result.*quantity).push_back(ExtrapolateInSize(radii, values));
        }
    return result;
}

}  // namespace lacquer::bulk
