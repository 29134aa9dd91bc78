// Translation of regular waves, through plane waves.
#pragma once

#include <vector>

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// Coefficients of regular waves about old origin + d from those of regular waves about the old origin, for
/// many d. In a frame along d a wave of order m is a sum of plane waves over the polar angle, each of which d
/// gives a phase; in the helicity basis
///
///   (A + B)^m_{nu n} = i^(nu - n) sqrt((2 nu + 1)(2 n + 1)) / 2  int_-1^1 e^{i kd x} d^nu_{m1} d^n_{m1} dx,
///
/// by Gauss and Legendre's rule with as many nodes as the largest d needs. Unlike recurrences in n it loses
/// no digits at high degrees. The translation by -d is the inverse and, between the same degrees, the
/// adjoint.
class RegularTranslation {
  public:
    /// @param maxDistance  the largest |d|, times k. Cost O((degree + maxDistance) degree^2)
    RegularTranslation(int fromDegree, int toDegree, double maxDistance);
    /// Cost O(degree^2 (degree + maxDistance)) for each column.
    /// @param d  times k, may be 0    @param coefficients  2 NumHarmonics(fromDegree) rows
    Eigen::MatrixXcd Apply(const Point& d, const Eigen::MatrixXcd& coefficients) const;
    /// 2 NumHarmonics(toDegree) rows, 2 NumHarmonics(fromDegree) columns.
    Eigen::MatrixXcd Matrix(const Point& d) const;

  private:
    int fromDegree_, toDegree_, maxOrder_;
    double maxDistance_;
    std::vector<double> cosines_;
    /// For each order m = -maxOrder ... maxOrder: (-i)^n sqrt((2n + 1) w / 2) d^n_{m1} without the power of
    /// i; rows n from max(1, |m|), a column for each node.
    std::vector<Eigen::MatrixXd> planeWaves_;
};

}  // namespace lacquer::bulk
