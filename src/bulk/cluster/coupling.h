// What the waves that each sphere of a cluster scatters are about all the others: the product of the linear
// system.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bulk/conventions.h"
#include "bulk/waves/lanes.h"

namespace lacquer::bulk {

class PairTableMaker;

/// Coefficients of two waves (columns, such as two polarisations) about many origins in the helicity basis
/// u = (M + N)/sqrt 2, v = (M - N)/sqrt 2, which translations leave apart. One entry for each origin and
/// harmonic: real parts u of column 0, u of column 1, v of 0, v of 1, and then their imaginary parts.
class HelicityWaves {
  public:
    HelicityWaves() = default;
    HelicityWaves(int numOrigins, int degree)
        : numHarmonics_(NumHarmonics(degree)), values_(size_t(numOrigins) * size_t(numHarmonics_), Lanes{}) {}
    size_t Size() const { return values_.size(); }
    Lanes* Data() { return values_.data(); }
    const Lanes* Data() const { return values_.data(); }
    Lanes* Of(int origin) { return &values_[size_t(origin) * size_t(numHarmonics_)]; }
    const Lanes* Of(int origin) const { return &values_[size_t(origin) * size_t(numHarmonics_)]; }
    /// From and to coefficients of M and N: 2 NumHarmonics rows, two columns.
    void Set(int origin, const Eigen::MatrixX2cd& coefficients);
    Eigen::MatrixX2cd Get(int origin) const;

  private:
    int numHarmonics_ = 0;
    std::vector<Lanes> values_;
};

/// Translations between all pairs of centres, by rotating, shifting along z and rotating back [Mackowski
/// 1991]. Both directions of a pair, two columns and both helicities share each number of its tables: 16
/// lanes.
///
/// Tables are kept for as many pairs as the given memory holds, and made anew in each product for the others.
/// Thread-safe after construction.
class Coupling {
  public:
    /// @param centers  times k, no two the same
    /// @param memory   bytes for tables
    Coupling(std::span<const Point> centers, int degree, size_t memory);
    /// For each i the sum over j != i of the translation of in_j to centre i. The same bits for any number of
    /// threads. Cost about 11 L^3 multiplications and additions for each pair, direction and column.
    void Apply(const HelicityWaves& in, HelicityWaves* out) const;

    int NumCenters() const { return int(centers_.size()); }
    int Degree() const { return degree_; }
    int64_t NumPairs() const { return int64_t(centers_.size()) * int64_t(centers_.size() - 1) / 2; }
    /// Doubles in the tables of one pair.
    static size_t TableSize(int degree);
    /// Floating-point operations of one Apply() with kept tables, multiplications and additions of the
    /// rotations and shifts.
    double NumOperations() const;

  private:
    struct Pair {
        int to, from;  ///< indices of centres, to < from
    };
    static constexpr int64_t kNumSlices = 8;  ///< of the pairs, each with sums of its own

    void MakeTables(int64_t batch, PairTableMaker* maker, double* tables) const;
    void ApplySlice(int64_t slice, const HelicityWaves& in, HelicityWaves* out) const;

    std::vector<Point> centers_;
    int degree_;
    std::vector<Pair> pairs_;
    int64_t numKeptBatches_ = 0;  ///< batches of kNumLanes pairs
    std::vector<double> kept_;
};

}  // namespace lacquer::bulk
