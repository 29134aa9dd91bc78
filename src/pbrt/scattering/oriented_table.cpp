#include "pbrt/scattering/oriented_table.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer {

OrientedGrid::OrientedGrid(std::span<const double> angles, int numAzimuths)
    : numAzimuths_(size_t(numAzimuths)), azimuthStep_(M_PI / (numAzimuths - 1)), weights_(angles.size(), 0.) {
    LACQUER_CHECK(angles.size() >= 3 && angles.size() % 2 == 1 && numAzimuths >= 2);
    constexpr double kHalf = M_PI / 360;
    for (size_t j = 0; j + 1 < angles.size(); ++j) {
        // The difference of two cosines, without cancellation.
        const double a = angles[j], b = angles[j + 1];
        const double range = 2 * std::sin(kHalf * (a + b)) * std::sin(kHalf * (b - a));
        weights_[j] += 0.5 * range;
        weights_[j + 1] += 0.5 * range;
    }
}

double OrientedGrid::MeanOverIncidences(std::span<const double> values) const {
    LACQUER_CHECK(values.size() == NumIncidences());
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i)
        sum += (i + 1 == values.size() ? 0.5 : 1.) * weights_[i] * values[i];
    return sum;
}

namespace {

void MakeIndependentOfAzimuth(const OrientedGrid& grid, double* values) {
    std::fill_n(values, grid.NumAzimuths(), grid.OverAzimuth(values) / (2 * M_PI));
}

void TakeMeansOfPairs(const OrientedGrid& grid, std::span<double> scattered) {
    const size_t middle = grid.NumIncidences() - 1, last = grid.NumAngles() - 1;
    for (size_t i = 0; i <= middle; ++i)
        for (const size_t j : {size_t(0), last}) MakeIndependentOfAzimuth(grid, &scattered[grid.Index(i, j)]);
    for (size_t j = 0; j <= last; ++j) MakeIndependentOfAzimuth(grid, &scattered[grid.Index(0, j)]);
    const auto takeMean = [&](size_t a, size_t b) {
        for (size_t k = 0; k < grid.NumAzimuths(); ++k)
            scattered[a + k] = scattered[b + k] = 0.5 * (scattered[a + k] + scattered[b + k]);
    };
    // Light across the axis has a mirror image that is across it, too.
    for (size_t j = 0; j < middle; ++j) takeMean(grid.Index(middle, j), grid.Index(middle, last - j));
    for (size_t i = 0; i <= middle; ++i)
        for (size_t j = 0; j <= last; ++j)
            if (const auto [a, b] = grid.Reciprocal(i, j); grid.Index(a, b) > grid.Index(i, j))
                takeMean(grid.Index(i, j), grid.Index(a, b));
    // Pairs with that light have two places there.
    for (size_t j = middle + 1; j <= last; ++j)
        std::copy_n(&scattered[grid.Index(middle, last - j)], grid.NumAzimuths(),
                    &scattered[grid.Index(middle, j)]);
}

/// Factors u of the incidences for which the integrals of u_i u_j scattered_ij are sigmaS [Sinkhorn 1967].
std::vector<double> BalancingFactors(const OrientedGrid& grid, std::span<const double> sigmaS,
                                     std::span<const double> scattered) {
    const size_t count = grid.NumIncidences(), last = grid.NumAngles() - 1;
    std::vector<double> matrix(count * count, 0.), factors(count, 1.);
    for (size_t i = 0; i < count; ++i)
        for (size_t j = 0; j <= last; ++j)
            matrix[i * count + std::min(j, last - j)] +=
                grid.Weight(j) * grid.OverAzimuth(&scattered[grid.Index(i, j)]);
    constexpr int kMaxSteps = 2000;
    constexpr double kTolerance = 1e-13;
    double worst = 1;
    for (int step = 0; step < kMaxSteps && worst > kTolerance; ++step) {
        worst = 0;
        std::vector<double> next = factors;
        for (size_t i = 0; i < count; ++i) {
            double sum = 0;
            for (size_t j = 0; j < count; ++j) sum += matrix[i * count + j] * factors[j];
            const double ratio = sum > 0 ? sigmaS[i] / (factors[i] * sum) : 1;
            worst = std::max(worst, std::abs(ratio - 1));
            next[i] *= std::sqrt(ratio);
        }
        factors = next;
    }
    return factors;
}

}  // namespace

double MakeReciprocal(const OrientedGrid& grid, std::span<const double> sigmaS, std::span<double> scattered) {
    LACQUER_CHECK(scattered.size() == grid.Size() && sigmaS.size() == grid.NumIncidences());
    const std::vector<double> before(scattered.begin(), scattered.end());
    TakeMeansOfPairs(grid, scattered);
    const std::vector<double> factors = BalancingFactors(grid, sigmaS, scattered);
    const size_t last = grid.NumAngles() - 1;
    std::vector<double> changes(before.size());
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        for (size_t j = 0; j <= last; ++j)
            for (size_t k = 0; k < grid.NumAzimuths(); ++k) {
                const size_t at = grid.Index(i, j) + k;
                scattered[at] *= factors[i] * factors[std::min(j, last - j)];
                changes[at] = std::abs(scattered[at] - before[at]);
            }
    std::vector<double> changed, all;
    for (size_t i = 0; i < grid.NumIncidences(); ++i) {
        changed.push_back(grid.OverSphere<double>(changes, i));
        all.push_back(grid.OverSphere<double>(scattered, i));
    }
    return grid.MeanOverIncidences(changed) / grid.MeanOverIncidences(all);
}

}  // namespace lacquer
