// Tables of the translation between two centres, in the order in which the product reads them.
#pragma once

#include <vector>

#include "bulk/waves/axial_translation.h"
#include "bulk/waves/lanes.h"

namespace lacquer::bulk {

/// Where things stand in the table of a pair. First rotations, degree by degree: matrices of the sums
/// c_m + (-1)^m c_{-m} (orders 0 to n) and of the differences (orders 1 to n), which rotations do not mix;
/// they hold half the numbers of d^n. Then shifts, order by order: A for m = 0, and A + B beside A - B for m
/// > 0, complex. Last cos(m phi) and sin(m phi).
class PairTableLayout {
  public:
    explicit PairTableLayout(int degree);
    int Degree() const { return degree_; }
    /// Entry (m, k) of the rotation is at (m * (n + 1) + k), m, k <= n.
    size_t Sums(int n) const { return sums_[size_t(n)]; }
    /// Entry (m, k) is at ((m - 1) * n + k - 1), 1 <= m, k <= n.
    size_t Differences(int n) const { return sums_[size_t(n)] + size_t(n + 1) * size_t(n + 1); }
    /// Entry (nu, n) is at ((nu - lo) * (degree - lo + 1) + n - lo) * (m == 0 ? 2 : 4), lo = max(1, m).
    size_t Shifts(int m) const { return shifts_[size_t(m)]; }
    /// Pairs (cos, sin) for m = 0 ... degree.
    size_t Phases() const { return phases_; }
    size_t Size() const { return size_; }

  private:
    int degree_;
    std::vector<size_t> sums_, shifts_;
    size_t phases_, size_;
};

/// Makes the tables of kNumLanes pairs at once. Not thread-safe: one for each thread.
class PairTableMaker {
  public:
    explicit PairTableMaker(const PairTableLayout& layout);
    /// @param displacements  from the origin with the larger index to that with the smaller one, times k
    /// @param tables         kNumLanes tables, one after the other
    void Make(const Point* displacements, double* tables);

  private:
    void MakeRotations(const Lanes& cosine, const Lanes& halfSine, const Lanes& halfCosine, double* tables);
    /// d^n_{mk} and d^n_{m,-k} for one m >= k >= 0 and all n, into the tables.
    void MakeRotationsOf(int m, int k, const Lanes& cosine, const Lanes* plusStart, const Lanes* minusStart,
                         double* tables);
    void MakeShifts(double* tables);
    void Store(double* tables, size_t place, const Lanes& values) const {
        for (int lane = 0; lane < kNumLanes; ++lane)
            tables[size_t(lane) * layout_.Size() + place] = values[lane];
    }

    PairTableLayout layout_;
    AxialTranslation axial_;
    std::vector<Lanes> besselJ_, besselY_;
    std::vector<Lanes> sinePowers_, cosinePowers_;
    /// Of d^m_{mk}: sqrt((2m)! / ((m-k)! (m+k)!)), for 0 <= k <= m in turn.
    std::vector<double> startFactors_;
};

}  // namespace lacquer::bulk
