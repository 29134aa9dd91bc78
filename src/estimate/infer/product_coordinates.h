// Coordinates in which ridges of products are straight.
#pragma once

#include <vector>

#include "estimate/parameters.h"

namespace lacquer::estimate {

/// Where the data tell the product of two parameters (light times albedo) far better than either, what is
/// observed follows thin curved ridges in logits. Here the coordinate of a factor is the logarithm of the
/// product (but near the largest one, which lies at infinity), across the ridge; that of its scale is the
/// logit of its place between the least and the largest value that these products leave it. So no bound is
/// met on the way along a ridge, and all real vectors are points, but for products that have no common scale.
/// All others are logits. Factors are parameters with Parameter::productWith.
class ProductCoordinates {
  public:
    /// @param space  outlives the object
    explicit ProductCoordinates(const ParameterSpace& space);
    /// Columns of logits to coordinates, and back. Products without a common scale are moved to bounds.
    Matrix FromLogits(const Matrix& y) const;
    Matrix ToLogits(const Matrix& t) const;
    /// Logits at t, and the logarithm of the determinant of dy/dt. False where products have no common scale.
    bool Logits(const Vector& t, Vector* y, double* logDeterminant) const;
    /// d/dt of a density of t, with its determinant, from d/dy of one of y at the logits of t.
    Vector GradientByCoordinates(const Vector& t, const Vector& byLogits) const;

  private:
    struct Factor {
        Eigen::Index index;
        double low, high;  ///< its bounds
        double largest;    ///< of its product with the scale
    };
    struct Group {
        Eigen::Index scale;
        double low, high;
        std::vector<Factor> factors;
    };
    /// What the coordinates of a group stand for.
    struct Place {
        std::vector<double> products;
        double low, high;     ///< between which the scale may lie
        int lowest, highest;  ///< factors that set these ends; -1: the scale's own bounds
        double scale;
    };
    /// False where products have no common scale.
    static bool Find(const Group& group, const Vector& t, Place* place);

    const ParameterSpace& space_;
    std::vector<Group> groups_;
};

}  // namespace lacquer::estimate
