#include "support/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "pbrt/core/rng.h"

namespace lacquer::test {
namespace {

// Regularised incomplete gamma function Q(a, x): a power series of P below the bend, a continued fraction of
// Q above it [Abramowitz and Stegun 1964, 6.5.29 and 6.5.31].
double GammaQ(double a, double x) {
    if (x <= 0) return 1;
    const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int n = 1; n < 100000 && term > 1e-17 * sum; ++n) sum += term *= x / (a + n);
        return std::max(0., 1 - front * sum);
    }
    // Lentz's evaluation of 1/(x+1-a- 1(1-a)/(x+3-a- ...)).
    double b = x + 1 - a, c = 1e300, d = 1 / b, fraction = d;
    for (int n = 1; n < 100000; ++n) {
        const double numerator = -n * (n - a);
        b += 2;
        d = 1 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= d * c;
        if (std::abs(d * c - 1) < 1e-15) break;
    }
    return front * fraction;
}

}  // namespace

double ChiSquareSurvival(double x, double degrees) { return GammaQ(degrees / 2, x / 2); }
double NormalTwoSided(double z) { return std::erfc(std::abs(z) / std::sqrt(2.)); }
double NormalUpper(double z) { return 0.5 * std::erfc(z / std::sqrt(2.)); }
double SidakAlpha(double family, int numTests) { return -std::expm1(std::log1p(-family) / numTests); }

Outcome WorstOf(std::span<const Outcome> outcomes) {
    const auto worst =
        std::min_element(outcomes.begin(), outcomes.end(),
                         [](const Outcome& a, const Outcome& b) { return a.pValue < b.pValue; });
    if (worst == outcomes.end()) return {};
    return {-std::expm1(double(outcomes.size()) * std::log1p(-std::min(worst->pValue, 1 - 1e-16))),
            worst->details};
}

Outcome ChiSquareTest(std::span<const double> observed, std::span<const double> expected,
                      double minExpected) {
    std::vector<size_t> order(expected.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });

    // Pool from the emptiest cells on.
    struct Pool {
        double observed = 0, expected = 0;
        size_t largest = 0;
        double Term() const { return (observed - expected) * (observed - expected) / expected; }
    };
    std::vector<Pool> pools;
    Pool pool;
    for (const size_t i : order) {
        pool = {pool.observed + observed[i], pool.expected + expected[i], i};
        if (pool.expected < minExpected) continue;
        pools.push_back(pool);
        pool = {};
    }
    if (pools.empty()) {
        // Too little is expected for this test: only a count that is far too large says something.
        const double excess = pool.observed - pool.expected;
        return {excess > 0 ? NormalUpper(excess / std::sqrt(std::max(pool.expected, minExpected))) : 1,
                fmt::format("no cell to test: {} observed, {} expected", pool.observed, pool.expected)};
    }
    pools.back().observed += pool.observed;
    pools.back().expected += pool.expected;

    // Sum up, and keep the worst cells for the report.
    double chiSquare = 0;
    for (const Pool& p : pools) chiSquare += p.Term();
    const size_t shown = std::min<size_t>(6, pools.size());
    std::partial_sort(pools.begin(), pools.begin() + long(shown), pools.end(),
                      [](const Pool& a, const Pool& b) { return a.Term() > b.Term(); });
    std::string details =
        fmt::format("chi-square {:.1f} at {} degrees of freedom; worst cells (observed/expected):", chiSquare,
                    pools.size());
    for (size_t i = 0; i < shown; ++i)
        details += fmt::format(" #{} {:.0f}/{:.1f}", pools[i].largest, pools[i].observed, pools[i].expected);
    return {ChiSquareSurvival(chiSquare, double(pools.size())), details};
}

double RunningMean::StandardError() const { return count_ > 0 ? std::sqrt(Variance() / double(count_)) : 0; }

Outcome ZTest(const RunningMean& mean, double expected, double bias, const std::string& what) {
    const double excess = std::max(0., std::abs(mean.Mean() - expected) - bias);
    const double sigma = mean.StandardError();
    const double pValue = excess == 0 ? 1 : sigma > 0 ? NormalTwoSided(excess / sigma) : 0;
    return {pValue, fmt::format("{}: {:.7g} +- {:.2g}, expected {:.7g}", what, mean.Mean(), sigma, expected)};
}

int Scaled(int numSamples) {
#ifdef LACQUER_SANITIZED
    return numSamples / 8;
#else
    return numSamples;
#endif
}

uint64_t SeedOf(const std::string& name) {
    uint64_t hash = name.size();
    for (const char c : name) hash = Hash(hash, c);
    return hash;
}

std::string FullTestName() {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    return info ? fmt::format("{}.{}", info->test_suite_name(), info->name()) : std::string();
}

testing::AssertionResult Passes(const std::string& name, double alpha,
                                const std::function<Outcome(uint64_t seed)>& check) {
    const uint64_t seed = SeedOf(name);
    return PassesAt(seed, name, alpha, check(seed), check);
}

testing::AssertionResult PassesAt(uint64_t seed, const std::string& name, double alpha, const Outcome& first,
                                  const std::function<Outcome(uint64_t seed)>& check) {
    if (first.pValue >= alpha) return testing::AssertionSuccess();
    constexpr uint64_t kOthers = 10;
    int failures = 0;
    for (uint64_t i = 1; i <= kOthers; ++i) failures += !(check(Hash(seed, i)).pValue >= alpha);
    return testing::AssertionFailure()
           << fmt::format("{}\n  p-value {:.3g} is below {:.3g}; {} of {} other seeds fail too\n  {}", name,
                          first.pValue, alpha, failures, kOthers, first.details);
}

}  // namespace lacquer::test
