#include "estimate/calibration/uniformity.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

namespace {

/// exp(-x) x^a / Gamma(a).
double GammaFactor(double a, double x) { return std::exp(-x + a * std::log(x) - std::lgamma(a)); }

double LogBinomial(int n, int k, double p) {
    if (p <= 0) return k == 0 ? 0 : -1e300;
    if (p >= 1) return k == n ? 0 : -1e300;
    return std::lgamma(n + 1.) - std::lgamma(k + 1.) - std::lgamma(n - k + 1.) + k * std::log(p) +
           (n - k) * std::log1p(-p);
}

}  // namespace

double ChiSquareTail(double x, double degrees) {
    const double a = degrees / 2, z = x / 2;
    if (z <= 0) return 1;
    if (z < a + 1) {
        // Series of the lower function [Abramowitz and Stegun 1964] 6.5.29.
        double term = 1 / a, sum = term;
        for (int n = 1; n < 1000 && term > 1e-16 * sum; ++n) sum += term *= z / (a + n);
        return std::clamp(1 - GammaFactor(a, z) * sum, 0., 1.);
    }
    // Continued fraction of the upper one, 6.5.31, by Lentz's method.
    double b = z + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int n = 1; n < 1000; ++n) {
        const double an = -n * (n - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (std::abs(d * c - 1) < 1e-15) break;
    }
    return GammaFactor(a, z) * h;
}

ChiSquareOfRanks TestRanks(const std::vector<int>& ranks, int numRanks, int bins) {
    LACQUER_CHECK(bins >= 2 && numRanks % bins == 0 && !ranks.empty());
    std::vector<double> counts(size_t(bins), 0);
    for (const int rank : ranks) ++counts[size_t(rank / (numRanks / bins))];
    const double expected = double(ranks.size()) / bins;
    double value = 0;
    for (const double count : counts) value += (count - expected) * (count - expected) / expected;
    return {value, bins - 1., ChiSquareTail(value, bins - 1)};
}

EcdfEnvelope::EcdfEnvelope(int sampleSize, int points, double probability)
    : sampleSize_(sampleSize), points_(points), lower_(size_t(points)), upper_(size_t(points)) {
    LACQUER_CHECK(sampleSize > 0 && points > 1);
    // The smaller a point's own level, the wider the limits and the larger their common coverage.
    double low = 1e-12, high = 1 - probability;
    for (int step = 0; step < 40; ++step) {
        const double middle = std::sqrt(low * high);
        SetLimits(middle);
        (Coverage() >= probability ? low : high) = middle;
    }
    level_ = low;
    SetLimits(low);
}

void EcdfEnvelope::SetLimits(double level) {
    for (int i = 1; i < points_; ++i) {
        // Widest limits outside of which lies at most half of the level on each side.
        const double p = double(i) / points_;
        double below = 0, above = 0;
        int lower = 0, upper = sampleSize_;
        for (; lower < sampleSize_; ++lower) {
            below += std::exp(LogBinomial(sampleSize_, lower, p));
            if (below > level / 2) break;
        }
        for (; upper > 0; --upper) {
            above += std::exp(LogBinomial(sampleSize_, upper, p));
            if (above > level / 2) break;
        }
        lower_[size_t(i)] = lower;
        upper_[size_t(i)] = upper;
    }
}

double EcdfEnvelope::Coverage() const {
    // Probabilities of the number of ranks below a point, given that all before stayed within. From one point
    // to the next, of those that are left each falls between with the same probability.
    std::vector<double> logFactorials(size_t(sampleSize_) + 1, 0);
    for (int n = 1; n <= sampleSize_; ++n)
        logFactorials[size_t(n)] = logFactorials[size_t(n - 1)] + std::log(n);
    std::vector<double> now(size_t(sampleSize_) + 1, 0), next;
    now[0] = 1;
    for (int i = 1; i < points_; ++i) {
        const double p = 1. / (points_ - i + 1), logP = std::log(p), logRest = std::log1p(-p);
        const int first = i == 1 ? 0 : lower_[size_t(i - 1)], last = i == 1 ? 0 : upper_[size_t(i - 1)];
        next.assign(now.size(), 0);
        for (int from = first; from <= last; ++from) {
            if (now[size_t(from)] == 0) continue;
            const int left = sampleSize_ - from;
            for (int to = std::max(from, lower_[size_t(i)]); to <= upper_[size_t(i)]; ++to) {
                const int more = to - from;
                next[size_t(to)] +=
                    now[size_t(from)] *
                    std::exp(logFactorials[size_t(left)] - logFactorials[size_t(more)] -
                             logFactorials[size_t(left - more)] + more * logP + (left - more) * logRest);
            }
        }
        now.swap(next);
    }
    double sum = 0;
    for (const double mass : now) sum += mass;
    return sum;
}

bool EcdfEnvelope::Contains(const std::vector<int>& ranks, int numRanks) const {
    LACQUER_CHECK(int(ranks.size()) == sampleSize_ && numRanks % points_ == 0);
    for (int i = 1; i < points_; ++i) {
        const int limit = i * (numRanks / points_);
        const auto count =
            int(std::count_if(ranks.begin(), ranks.end(), [&](int rank) { return rank < limit; }));
        if (count < Lower(i) || count > Upper(i)) return false;
    }
    return true;
}

}  // namespace lacquer::estimate
