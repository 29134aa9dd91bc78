// A distribution to sample from, on all real vectors.
#pragma once

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// A density known up to a constant. Const functions may be called from several threads at once and give the
/// same bits for the same arguments.
class Target {
  public:
    virtual ~Target() = default;
    virtual Eigen::Index Size() const = 0;
    /// Logarithm of the density at y; -inf or NaN where it is zero.
    /// @param gradient  its gradient, where the target has one; null: not wanted
    virtual double LogDensity(const Vector& y, Vector* gradient) const = 0;
};

/// The density of q where y = center + transform q has the density of another target: with a transform whose
/// product with its transpose is near the covariance, all directions of q are alike (a dense metric).
class WhitenedTarget final : public Target {
  public:
    /// @param target     outlives the object
    /// @param transform  square and invertible
    WhitenedTarget(const Target& target, Vector center, Matrix transform)
        : target_(target), center_(std::move(center)), transform_(std::move(transform)) {}
    Eigen::Index Size() const override { return center_.size(); }
    Vector Original(const Vector& q) const { return center_ + transform_ * q; }
    double LogDensity(const Vector& q, Vector* gradient) const override {
        const double value = target_.LogDensity(Original(q), gradient);
        if (gradient) *gradient = transform_.transpose() * *gradient;
        return value;
    }

  private:
    const Target& target_;
    Vector center_;
    Matrix transform_;
};

}  // namespace lacquer::estimate
