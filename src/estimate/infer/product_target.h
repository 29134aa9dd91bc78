// Walks along the ridges of products, and not across them.
#pragma once

#include "estimate/infer/product_coordinates.h"
#include "estimate/infer/target.h"

namespace lacquer::estimate {

/// A target of logits y, seen in the coordinates in which its products are straight. Products without a
/// common scale have density zero.
class ProductTarget final : public Target {
  public:
    /// Both outlive the object.
    ProductTarget(const ParameterSpace& space, const Target& target) : coordinates_(space), target_(target) {}
    Eigen::Index Size() const override { return target_.Size(); }
    double LogDensity(const Vector& t, Vector* gradient) const override;

    Matrix FromLogits(const Matrix& y) const { return coordinates_.FromLogits(y); }
    Matrix ToLogits(const Matrix& t) const { return coordinates_.ToLogits(t); }

  private:
    ProductCoordinates coordinates_;
    const Target& target_;
};

}  // namespace lacquer::estimate
