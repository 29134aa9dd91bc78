// Coordinates in which ridges of products are straight.
#pragma once

#include <vector>

#include "estimate/infer/target.h"
#include "estimate/parameters.h"

namespace lacquer::estimate {

/// A target of logits y, seen in coordinates t: where the data tell the product of two parameters (light
/// times albedo) far better than either, the posterior is a thin curved ridge in y. Here the factor's
/// coordinate is the logarithm of the product, which lies across the ridge. Points whose factor would leave
/// its bounds have density zero.
class ProductTarget final : public Target {
  public:
    /// Both outlive the object. Factors are those with Parameter::productWith.
    ProductTarget(const ParameterSpace& space, const Target& target);
    Eigen::Index Size() const override { return target_.Size(); }
    double LogDensity(const Vector& t, Vector* gradient) const override;

    /// Columns of logits to coordinates, and back. A point outside of the bounds is moved to them.
    Matrix FromLogits(const Matrix& y) const;
    Matrix ToLogits(const Matrix& t) const;

  private:
    struct Factor {
        Eigen::Index index, scale;  ///< of the factor, and of what it is multiplied by
        double low, high;
    };
    /// The factors' values at t. False where one is outside of its bounds.
    bool Values(const Vector& t, Vector* x) const;

    const ParameterSpace& space_;
    const Target& target_;
    std::vector<Factor> factors_;
};

}  // namespace lacquer::estimate
