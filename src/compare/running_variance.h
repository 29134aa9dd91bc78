// Mean and variance of numbers as they come.
#pragma once

namespace lacquer::compare {

/// Mean and sum of squared deviations [Welford 1962].
class RunningVariance {
  public:
    void Add(double x) {
        const double delta = x - mean_;
        mean_ += delta / ++count_;
        m2_ += delta * (x - mean_);
    }
    double Mean() const { return mean_; }
    /// Of the mean, from at least two numbers: their sample variance over their count.
    double VarianceOfMean() const { return Variance() / count_; }
    /// Sample variance of at least two numbers.
    double Variance() const { return m2_ / (count_ - 1.0); }
    int Count() const { return count_; }

  private:
    double mean_ = 0, m2_ = 0;
    int count_ = 0;
};

}  // namespace lacquer::compare
