// The inner loop of clusters: waves from either centre of a pair to the other.
#pragma once

#include <vector>

#include "bulk/cluster/pair_tables.h"
#include "bulk/waves/lanes.h"

namespace lacquer::bulk {

/// Buffers of one thread, and the product with the table of a pair.
class PairProduct {
  public:
    explicit PairProduct(const PairTableLayout& layout);
    /// Adds to `toFirst` the waves `fromSecond` about the pair's first centre, and to `toSecond` the waves
    /// `fromFirst` about its second one.
    void Apply(const double* table, const Lanes* fromSecond, const Lanes* fromFirst, Lanes* toFirst,
               Lanes* toSecond);

  private:
    void Load(const double* phases, const Lanes* fromSecond, const Lanes* fromFirst);
    void RotateIntoFrame(const double* table);
    void Shift(const double* table);
    void RotateOutOfFrame(const double* table);
    void AddTo(const double* phases, Lanes* toFirst, Lanes* toSecond) const;

    PairTableLayout layout_;
    /// Real and imaginary parts (two entries each) of the sums of orders 0 to n, and then of the differences
    /// of orders 1 to n, degree by degree.
    std::vector<Lanes> parts_, turned_;
    /// Those of one order from all degrees, before and after the shift.
    std::vector<Lanes> order_, shifted_;
};

}  // namespace lacquer::bulk
