// Mean, deviation and quantiles of draws.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace lacquer::estimate {

struct SampleMoments {
    double mean = 0, sd = 0;  ///< sd with n - 1: NaN for a single value
};
inline SampleMoments MomentsOf(const std::vector<double>& values) {
    const double n = double(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.) / n;
    double squares = 0;
    for (const double v : values) squares += (v - mean) * (v - mean);
    return {mean, std::sqrt(squares / (n - 1))};
}

/// The value below which a part p of sorted values lies, linear between them. There is at least one.
inline double SortedQuantile(const std::vector<double>& sorted, double p) {
    const double place = p * double(sorted.size() - 1);
    const auto below = size_t(place);
    return below + 1 < sorted.size()
               ? sorted[below] + (place - double(below)) * (sorted[below + 1] - sorted[below])
               : sorted[below];
}

}  // namespace lacquer::estimate
