// Are ranks uniform?
#pragma once

#include <vector>

namespace lacquer::estimate {

/// Probability that a chi-square variable with `degrees` degrees of freedom exceeds x >= 0: the regularised
/// upper incomplete gamma function, to 1e-12.
double ChiSquareTail(double x, double degrees);

/// Pearson's test of ranks 0 ... numRanks - 1 against uniformity, in `bins` that divide numRanks.
struct ChiSquareOfRanks {
    double value;
    double degrees;
    double pValue;
};
ChiSquareOfRanks TestRanks(const std::vector<int>& ranks, int numRanks, int bins);

/// Limits between which the whole distribution function of uniform ranks stays with a given probability
/// [Sailynoja et al. 2022].
class EcdfEnvelope {
  public:
    /// @param sampleSize    ranks that were drawn
    /// @param points        the interval is looked at in 1/points, 2/points ...
    /// @param probability   of all points together, 0.99 for a test at 1 %
    EcdfEnvelope(int sampleSize, int points, double probability);
    /// Limits of the number of ranks below i / points, i from 1 to points - 1.
    int Lower(int i) const { return lower_[size_t(i)]; }
    int Upper(int i) const { return upper_[size_t(i)]; }
    int Points() const { return points_; }
    /// Probability that is left outside of each point's own limits.
    double PointwiseLevel() const { return level_; }
    /// True if ranks 0 ... numRanks - 1 stay within. `points` divides numRanks.
    bool Contains(const std::vector<int>& ranks, int numRanks) const;

  private:
    void SetLimits(double level);
    /// Probability that uniform numbers stay within the limits, by recursion over the points.
    double Coverage() const;

    int sampleSize_, points_;
    double level_ = 0;
    std::vector<int> lower_, upper_;
};

}  // namespace lacquer::estimate
