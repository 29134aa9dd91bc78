// Rotation of waves into a frame whose z axis is a given direction.
#pragma once

#include "bulk/conventions.h"
#include "bulk/waves/wigner.h"

namespace lacquer::bulk {

/// Coefficients in a frame along an axis, of the orders that a translation along it needs: |m| <= maxOrder.
/// Those of other orders come out as zero. Cost O(degree^2 maxOrder) for each column.
class AxisFrame {
  public:
    /// @param axis  of any length, 0 being z    @param degree  the largest one of what is turned
    AxisFrame(const Point& axis, int degree, int maxOrder);
    /// @param coefficients  2 NumHarmonics(degree) rows; both parts are turned alike
    Eigen::MatrixXcd Into(const Eigen::MatrixXcd& coefficients, int degree) const;
    Eigen::MatrixXcd OutOf(const Eigen::MatrixXcd& coefficients, int degree) const;

  private:
    double phi_;
    WignerD d_;
};

}  // namespace lacquer::bulk
