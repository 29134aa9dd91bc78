// Translation of waves in any direction: rotate, shift along z, rotate back. Plain and general; what clusters
// use in their inner loop is cluster/coupling.h.
#pragma once

#include "bulk/conventions.h"
#include "bulk/waves/axial_translation.h"
#include "bulk/waves/wigner.h"

namespace lacquer::bulk {

enum class WaveKind {
    Outgoing,  ///< h_n about the old origin
    Regular    ///< j_n about the old origin
};

/// Coefficients of regular waves about old origin + d from those of waves about the old origin [Mackowski
/// 1991]. Cost O(degree^3) for each column.
class Translation {
  public:
    /// @param d  times k; not 0 for outgoing waves
    Translation(const Point& d, WaveKind kind, int fromDegree, int toDegree);
    /// @param coefficients  2 NumHarmonics(fromDegree) rows
    Eigen::MatrixXcd Apply(const Eigen::MatrixXcd& coefficients) const;
    /// The adjoint of Apply(): for regular waves the way back, from origin + d to the origin.
    Eigen::MatrixXcd ApplyAdjoint(const Eigen::MatrixXcd& coefficients) const;
    /// 2 NumHarmonics(toDegree) rows, 2 NumHarmonics(fromDegree) columns.
    Eigen::MatrixXcd Matrix() const;

  private:
    Eigen::MatrixXcd IntoFrame(const Eigen::MatrixXcd& coefficients, int degree) const;
    Eigen::MatrixXcd OutOfFrame(const Eigen::MatrixXcd& coefficients, int degree) const;

    int fromDegree_, toDegree_, maxOrder_;
    double phi_;
    WignerD d_;
    /// A + B of each order m = -maxOrder ... maxOrder; A - B is that of -m. Rows nu and columns n from max(1,
    /// |m|).
    std::vector<Eigen::MatrixXcd> shifts_;
};

}  // namespace lacquer::bulk
