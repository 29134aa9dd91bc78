// Statistical checks for tests: p-values, and a runner that seeds, judges and reports them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace lacquer::test {

/// Probability that a chi-square variable with `degrees` > 0 degrees of freedom exceeds x.
double ChiSquareSurvival(double x, double degrees);
/// Probability that a standard normal variable is at least |z| away from 0.
double NormalTwoSided(double z);
/// Probability that it exceeds z.
double NormalUpper(double z);
/// Significance of each of `numTests` tests such that all together raise a false alarm with probability
/// `family` [Sidak 1967].
double SidakAlpha(double family, int numTests);

/// What one run of a check found.
struct Outcome {
    double pValue = 1;    ///< probability of a deviation like this or worse if the claim holds
    std::string details;  ///< for the report of a failure
};
/// The worst of several outcomes of one check, corrected for their number.
Outcome WorstOf(std::span<const Outcome> outcomes);

/// Pearson's test of `observed` counts against `expected` ones. Cells are pooled in order of their
/// expectation until each pool expects at least `minExpected`; what is left joins the last pool. Counts where
/// (almost) nothing is expected thus count too. No degree of freedom is lost to a total: the expectation is
/// absolute.
Outcome ChiSquareTest(std::span<const double> observed, std::span<const double> expected,
                      double minExpected = 5);

/// Mean of numbers as they come, with its standard error.
class RunningMean {
  public:
    void Add(double x) {
        ++count_;
        sum_ += x;
        squares_ += x * x;
    }
    int64_t Count() const { return count_; }
    double Mean() const { return count_ > 0 ? sum_ / double(count_) : 0; }
    double Variance() const {
        return count_ > 1 ? std::max(0., squares_ - sum_ * Mean()) / double(count_ - 1) : 0;
    }
    double StandardError() const;

  private:
    int64_t count_ = 0;
    double sum_ = 0, squares_ = 0;
};

/// Test of a mean against an expected value. `bias` bounds the errors that are not random (rounding,
/// quadrature).
Outcome ZTest(const RunningMean& mean, double expected, double bias, const std::string& what);

/// A number of samples, or an eighth of it under sanitizers, which look for undefined behaviour only.
int Scaled(int numSamples);

/// The seed that belongs to a name: nobody picks it.
uint64_t SeedOf(const std::string& name);
/// "Suite.Test/param" of the running test.
std::string FullTestName();

/// Runs `check` with the seed of `name` and passes if its p-value is not below `alpha`. On failure it runs
/// ten other seeds and reports how many of them fail too: all of them means a bug, none of them a false
/// alarm.
testing::AssertionResult Passes(const std::string& name, double alpha,
                                const std::function<Outcome(uint64_t seed)>& check);
/// The same where the run with the check's own `seed` has been made already and found `first`.
testing::AssertionResult PassesAt(uint64_t seed, const std::string& name, double alpha, const Outcome& first,
                                  const std::function<Outcome(uint64_t seed)>& check);

}  // namespace lacquer::test
