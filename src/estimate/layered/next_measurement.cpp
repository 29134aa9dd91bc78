#include "estimate/layered/next_measurement.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

std::vector<NextDirection> RankDirections(const std::vector<DirectionAngles>& directions, const Matrix& draws,
                                          const Matrix& predicted, double noise) {
    const auto count = Eigen::Index(directions.size());
    LACQUER_CHECK(count > 0 && predicted.rows() >= 2 * draws.rows() + 2 && predicted.cols() % count == 0);
    const Eigen::Index channels = predicted.cols() / count;
    const Matrix centered = predicted.rowwise() - predicted.colwise().mean();
    const Matrix columns = (draws.colwise() - draws.rowwise().mean()).transpose();
    const Matrix fitted = columns * columns.colPivHouseholderQr().solve(centered);
    const auto n = double(predicted.rows()), d = double(draws.rows());
    const Vector ofNoise = (centered - fitted).colwise().squaredNorm() / (n - 1 - d);
    const Vector variances = (fitted.colwise().squaredNorm().transpose() - d * ofNoise) / (n - 1);
    std::vector<NextDirection> ranked;
    for (Eigen::Index i = 0; i < count; ++i) {
        const double variance = std::max(0., variances.segment(i * channels, channels).mean());
        ranked.push_back({directions[size_t(i)], std::sqrt(variance), variance / (noise * noise)});
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const NextDirection& a, const NextDirection& b) { return a.ratio > b.ratio; });
    return ranked;
}

}  // namespace lacquer::estimate
