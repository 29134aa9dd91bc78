// Coordinates in which ridges of products are straight.
#pragma once

#include <vector>

#include "estimate/parameters.h"

namespace lacquer::estimate {

/// Where the data tell the product of two parameters (light times albedo) far better than either, what is
/// observed follows thin curved ridges in logits. Here the factor's coordinate is the logarithm of the
/// product, which lies across the ridge; all others are logits. Factors are parameters with
/// Parameter::productWith.
class ProductCoordinates {
  public:
    /// @param space  outlives the object
    explicit ProductCoordinates(const ParameterSpace& space);
    /// Columns of logits to coordinates, and back. A point outside of the bounds is moved to them.
    Matrix FromLogits(const Matrix& y) const;
    Matrix ToLogits(const Matrix& t) const;
    /// d/dy of a function of t, from its d/dt.
    Vector GradientByLogits(const Vector& y, const Vector& byCoordinates) const;
    /// Logits at t, and the logarithm of the determinant of dy/dt. False where a factor is outside of its
    /// bounds.
    bool Logits(const Vector& t, Vector* y, double* logDeterminant) const;
    /// d/dt of a density of t, with its determinant, from d/dy of one of y at the logits of t.
    Vector GradientByCoordinates(const Vector& y, const Vector& byLogits) const;

  private:
    struct Factor {
        Eigen::Index index, scale;  ///< of the factor, and of what it is multiplied by
        double low, high;
    };
    /// The factors' values at t. False where one is outside of its bounds.
    bool Values(const Vector& t, Vector* x) const;

    const ParameterSpace& space_;
    std::vector<Factor> factors_;
};

}  // namespace lacquer::estimate
