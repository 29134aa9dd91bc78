#include "estimate/diagnostics/convergence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "estimate/diagnostics/sample_moments.h"
#include "estimate/normal_distribution.h"

namespace lacquer::estimate {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool IsUsable(const Matrix& draws) {
    return draws.rows() >= 4 && draws.cols() > 0 && draws.allFinite() && draws.maxCoeff() > draws.minCoeff();
}

/// First and last halves of chains as chains; of an odd number the middle draw is left out.
Matrix Split(const Matrix& draws) {
    const Eigen::Index half = draws.rows() / 2;
    Matrix split(half, 2 * draws.cols());
    split << draws.topRows(half), draws.bottomRows(half);
    return split;
}

/// Normal scores of the ranks; equal draws share the mean of their ranks.
Matrix RankNormalized(const Matrix& draws) {
    const auto count = size_t(draws.size());
    std::vector<size_t> order(count);
    std::iota(order.begin(), order.end(), size_t(0));
    const double* values = draws.data();
    std::sort(order.begin(), order.end(), [values](size_t a, size_t b) { return values[a] < values[b]; });
    Matrix scores(draws.rows(), draws.cols());
    for (size_t first = 0, last; first < count; first = last) {
        for (last = first + 1; last < count && values[order[last]] == values[order[first]];) ++last;
        const double rank = 0.5 * double(first + 1 + last);
        const double score = NormalQuantile((rank - 0.375) / (double(count) + 0.25));
        for (size_t i = first; i < last; ++i) scores.data()[order[i]] = score;
    }
    return scores;
}

double Quantile(const Matrix& draws, double p) {
    std::vector<double> sorted(draws.data(), draws.data() + draws.size());
    std::sort(sorted.begin(), sorted.end());
    return SortedQuantile(sorted, p);
}

/// Variances within chains and of all draws, as R-hat and effective sizes have them.
struct Variances {
    double within, total;
    explicit Variances(const Matrix& chains) {
        const auto n = double(chains.rows());
        const Eigen::RowVectorXd means = chains.colwise().mean();
        within = (chains.rowwise() - means).squaredNorm() / (n - 1) / double(chains.cols());
        const double between = (means.array() - means.mean()).square().sum() / double(chains.cols() - 1);
        total = within * (n - 1) / n + between;
    }
};

double PlainRhat(const Matrix& chains) {
    const Variances v(chains);
    return v.within > 0 ? std::sqrt(v.total / v.within) : std::numeric_limits<double>::infinity();
}

/// Autocovariance at a lag, the mean over chains.
double Autocovariance(const Matrix& centered, Eigen::Index lag) {
    const Eigen::Index n = centered.rows();
    return centered.topRows(n - lag).cwiseProduct(centered.bottomRows(n - lag)).sum() /
           double(n * centered.cols());
}

double EssOfChains(const Matrix& chains) {
    const Eigen::Index n = chains.rows();
    const double count = double(chains.size()), scale = double(n) / double(n - 1);
    const Variances v(chains);
    if (!(v.total > 0)) return kNaN;
    const Matrix centered = chains.rowwise() - chains.colwise().mean();
    const auto correlation = [&](Eigen::Index lag) {
        return 1 - (v.within - Autocovariance(centered, lag) * scale) / v.total;
    };
    // Sums of neighbouring correlations of a reversible chain are positive and fall; the first that is not is
    // noise.
    double sum = -1, smallest = std::numeric_limits<double>::infinity();
    for (Eigen::Index lag = 0; lag + 1 < n; lag += 2) {
        const double pair = correlation(lag) + correlation(lag + 1);
        if (!(pair > 0)) break;
        smallest = std::min(smallest, pair);
        sum += 2 * smallest;
    }
    return count / std::max(sum, 1 / std::log10(count));
}

double QuantileEss(const Matrix& split, double p) {
    const double quantile = Quantile(split, p);
    return EssOfChains((split.array() <= quantile).cast<double>().matrix());
}

}  // namespace

double SplitRhat(const Matrix& draws) {
    if (!IsUsable(draws)) return kNaN;
    const Matrix split = Split(draws), folded = (split.array() - Quantile(split, 0.5)).abs().matrix();
    return std::max(PlainRhat(RankNormalized(split)), PlainRhat(RankNormalized(folded)));
}

double BulkEss(const Matrix& draws) {
    return IsUsable(draws) ? EssOfChains(RankNormalized(Split(draws))) : kNaN;
}

double TailEss(const Matrix& draws) {
    if (!IsUsable(draws)) return kNaN;
    const Matrix split = Split(draws);
    return std::min(QuantileEss(split, 0.05), QuantileEss(split, 0.95));
}

double MeanEss(const Matrix& draws) { return IsUsable(draws) ? EssOfChains(Split(draws)) : kNaN; }

double EBfmi(const std::vector<double>& energies) {
    if (energies.size() < 2) return kNaN;
    const double mean = std::accumulate(energies.begin(), energies.end(), 0.) / double(energies.size());
    double steps = 0, spread = 0;
    for (size_t i = 0; i < energies.size(); ++i) {
        spread += (energies[i] - mean) * (energies[i] - mean);
        if (i > 0) steps += (energies[i] - energies[i - 1]) * (energies[i] - energies[i - 1]);
    }
    return steps / spread;
}

Convergence ConvergenceOf(const Matrix& draws) { return {SplitRhat(draws), BulkEss(draws), TailEss(draws)}; }

}  // namespace lacquer::estimate
