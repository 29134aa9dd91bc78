#include "estimate/layered/next_measurement.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

std::vector<NextDirection> RankDirections(const std::vector<DirectionAngles>& directions,
                                          const LobeRuns& predicted, double noise) {
    const auto count = Eigen::Index(directions.size());
    LACQUER_CHECK(count > 0 && predicted.values.rows() > 1 && predicted.values.cols() % count == 0);
    const Eigen::Index channels = predicted.values.cols() / count;
    const Matrix centered = predicted.values.rowwise() - predicted.values.colwise().mean();
    const auto n = double(centered.rows());
    const Vector variances = (centered.colwise().squaredNorm() / (n - 1)).transpose(),
                 ofErrors = (predicted.errors.colwise().squaredNorm() / n).transpose();
    std::vector<NextDirection> ranked;
    for (Eigen::Index i = 0; i < count; ++i) {
        const double variance = std::max(0., (variances - ofErrors).segment(i * channels, channels).mean());
        ranked.push_back({directions[size_t(i)], std::sqrt(variance), variance / (noise * noise)});
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const NextDirection& a, const NextDirection& b) { return a.ratio > b.ratio; });
    return ranked;
}

}  // namespace lacquer::estimate
