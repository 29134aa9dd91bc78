// Rotation of spherical harmonics.
#pragma once

#include <vector>

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// log(i!) for i = 0 ... n. Unlike std::lgamma it may be called from several threads.
std::vector<double> LogFactorials(int n);

/// d^n_{mk}(beta) for n = 0 ... degree and |k| <= maxOrder, in Varshalovich's sign: d^1_{10} =
/// -sin(beta)/sqrt 2 [Varshalovich et al. 1988, ch. 4]. Cost and memory O(degree^2 maxOrder).
class WignerD {
  public:
    WignerD(int degree, double beta, int maxOrder);
    int Degree() const { return int(matrices_.size()) - 1; }
    /// Row m + n, column k + min(n, maxOrder).
    const Eigen::MatrixXd& Of(int n) const { return matrices_[size_t(n)]; }
    /// Orders of the columns of Of(n) reach from -MaxOrder(n) to MaxOrder(n).
    int MaxOrder(int n) const { return std::min(n, maxOrder_); }
    /// 0 for orders beyond n.
    double At(int n, int m, int k) const {
        return std::abs(m) > n || std::abs(k) > n ? 0 : matrices_[size_t(n)](m + n, k + MaxOrder(n));
    }

  private:
    int maxOrder_;
    std::vector<Eigen::MatrixXd> matrices_;
};

}  // namespace lacquer::bulk
