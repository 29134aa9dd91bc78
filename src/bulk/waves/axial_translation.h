// Translation of waves along z: coefficients of the recurrences of [Mackowski 1991], for many distances at
// once.
#pragma once

#include <algorithm>
#include <vector>

#include "bulk/conventions.h"
#include "bulk/waves/lanes.h"

namespace lacquer::bulk {

/// A^m_{nu n} + B and A - B for m >= 0: what a wave of degree n about a point gives of degree nu about
/// another one, at distance kd along +z. In the helicity basis (M + N)/sqrt 2, (M - N)/sqrt 2 translations do
/// not mix the two: the first is multiplied by A + B, the second by A - B; for -m they change places.
///
/// From outgoing waves to regular ones. Rounding grows with the degree: between touching
/// spheres fields hold 1e-10 at degree 50, 1e-7 at 80 and 2e-4 at 120.
class AxialTranslation {
  public:
    /// For waves of degree n <= fromDegree, as waves of degree nu <= toDegree.
    AxialTranslation(int fromDegree, int toDegree);
    /// @param besselJ, besselY  NumBessel() values j_nu and y_nu of kd
    void Compute(const Lanes& kd, const Lanes* besselJ, const Lanes* besselY);

    int NumBessel() const { return fromDegree_ + toDegree_ + 3; }
    int MaxOrder() const { return std::min(fromDegree_, toDegree_); }
    /// Real and imaginary part of A and of B / i (B = i times a real multiple of alpha).
    struct Entry {
        Lanes aReal, aImag, bReal, bImag;
    };
    /// max(1, m) <= nu <= toDegree, and the same for n <= fromDegree.
    void Get(int m, int nu, int n, Entry* entry) const;

  private:
    size_t AlphaIndex(int m, int nu, int n) const {
        return (size_t(m) * size_t(toDegree_ + 2) + size_t(nu)) * size_t(fromDegree_ + 1) + size_t(n);
    }
    /// Of cos(theta) Y_nm = a(n, m) Y_{n+1,m} + a(n-1, m) Y_{n-1,m}; 0 for n < m.
    double CosineFactor(int n, int m) const {
        return cosineFactors_[size_t(n + 1) * size_t(fromDegree_ + 1) + size_t(m)];
    }
    /// alpha of one real part from z_nu.
    void ComputeScalar(const Lanes* bessel, std::vector<Lanes>* alpha);

    int fromDegree_, toDegree_;
    Lanes kd_{};
    std::vector<double> cosineFactors_, degreeFactors_;  ///< the latter 1/sqrt(n(n+1))
    std::vector<Lanes> real_, imaginary_;                ///< alpha^m_{nu n}, nu <= toDegree + 1
    std::vector<Lanes> sectorial_, nextSectorial_;       ///< alpha^m_{nu m}
    std::vector<Lanes> columns_[3];                      ///< alpha^m_{nu n} for three n, all nu
};

}  // namespace lacquer::bulk
