// Polynomials of several variables.
#pragma once

#include <vector>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// All products of at most `degree` of `numVariables` variables: 1 first, then the variables, then squares
/// and products of two, of three.
class Monomials {
  public:
    Monomials() = default;
    /// @param degree  1, 2 or 3
    Monomials(Eigen::Index numVariables, int degree);
    Eigen::Index Size() const { return Eigen::Index(terms_.size()); }
    Vector At(const Vector& t) const;
    /// d/dt of sum_i weights_i m_i(t).
    Vector Gradient(const Vector& t, const Vector& weights) const;

  private:
    struct Term {
        int degree;
        Eigen::Index variables[3];
    };
    Eigen::Index numVariables_ = 0;
    std::vector<Term> terms_;
};

}  // namespace lacquer::estimate
