// Translation of outgoing waves in any direction: rotate, shift along z, rotate back. Plain and general; what
// clusters use in their inner loop is cluster/coupling.h.
#pragma once

#include <vector>

#include "bulk/conventions.h"
#include "bulk/waves/axis_frame.h"

namespace lacquer::bulk {

/// Coefficients of regular waves about old origin + d from those of outgoing waves about the old origin
/// [Mackowski 1991]. Cost O(degree^3) for each column.
class Translation {
  public:
    /// @param d  times k; not 0
    Translation(const Point& d, int fromDegree, int toDegree);
    /// @param coefficients  2 NumHarmonics(fromDegree) rows
    Eigen::MatrixXcd Apply(const Eigen::MatrixXcd& coefficients) const;
    /// 2 NumHarmonics(toDegree) rows, 2 NumHarmonics(fromDegree) columns.
    Eigen::MatrixXcd Matrix() const;

  private:
    int fromDegree_, toDegree_, maxOrder_;
    AxisFrame frame_;
    /// A + B of each order m = -maxOrder ... maxOrder; A - B is that of -m. Rows nu and columns n from max(1,
    /// |m|).
    std::vector<Eigen::MatrixXcd> shifts_;
};

}  // namespace lacquer::bulk
