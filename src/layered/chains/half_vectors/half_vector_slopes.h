// Small matrices and Gaussians in the plane of slopes, for chains of rough interfaces.
//
// The slope of a direction w is (w.x/w.z, w.y/w.z): a direction and its opposite share it.
#pragma once

#include "pbrt/core/rng.h"

namespace lacquer::layered::slopes {

/// A slope, or a difference or gradient of slopes. (Compilers keep its two numbers apart in registers, which
/// they do not with the unions of a glm vector.)
struct Slope {
    float x = 0, y = 0;

    Slope operator+(Slope b) const { return {x + b.x, y + b.y}; }
    Slope operator-(Slope b) const { return {x - b.x, y - b.y}; }
    Slope operator*(float s) const { return {x * s, y * s}; }
    friend Slope operator*(float s, Slope a) { return a * s; }
    Slope& operator+=(Slope b) { return *this = *this + b; }
};
inline float Dot(Slope a, Slope b) { return a.x * b.x + a.y * b.y; }

/// Symmetric 2x2 matrix: a covariance or a precision.
struct Symmetric {
    float xx = 0, xy = 0, yy = 0;

    Slope operator*(Slope v) const { return {xx * v.x + xy * v.y, xy * v.x + yy * v.y}; }
    Symmetric operator*(float s) const { return {xx * s, xy * s, yy * s}; }
    Symmetric operator+(Symmetric b) const { return {xx + b.xx, xy + b.xy, yy + b.yy}; }
    /// Adds s v v^T.
    Symmetric PlusSquare(float s, Slope v) const {
        return {xx + s * v.x * v.x, xy + s * v.x * v.y, yy + s * v.y * v.y};
    }
    /// The inverse of a positive definite matrix; where rounding hides that it is one, some large matrix.
    Symmetric Inverse() const {
        constexpr float kThinnest = 1e-6f;
        const float determinant = std::max(xx * yy - xy * xy, kThinnest * xx * yy), s = 1 / determinant;
        return {yy * s, -xy * s, xx * s};
    }
};

/// 2x2 matrix, rows first.
struct Matrix {
    float xx = 1, xy = 0, yx = 0, yy = 1;

    Slope operator*(Slope v) const { return {xx * v.x + xy * v.y, yx * v.x + yy * v.y}; }
    Slope TransposeTimes(Slope v) const { return {xx * v.x + yx * v.y, xy * v.x + yy * v.y}; }
    /// M S M^T.
    Symmetric Spread(Symmetric s) const {
        const Slope a = s * Slope{xx, xy}, b = s * Slope{yx, yy};
        return {a.x * xx + a.y * xy, a.x * yx + a.y * yy, b.x * yx + b.y * yy};
    }
    /// M^T S M.
    Symmetric PullBack(Symmetric s) const {
        const Slope a = s * Slope{xx, yx}, b = s * Slope{xy, yy};
        return {a.x * xx + a.y * yx, a.x * xy + a.y * yy, b.x * xy + b.y * yy};
    }
};

/// scale * (I + a b^T).
inline Matrix ScaledShear(float scale, Slope a, Slope b) {
    return {scale * (1 + a.x * b.x), scale * a.x * b.y, scale * a.y * b.x, scale * (1 + a.y * b.y)};
}

/// Normal density over slopes. Any finite precision with a positive diagonal gives a proper one.
class Gaussian {
  public:
    Gaussian() = default;
    /// exp(gradient^T d - d^T precision d / 2), d being the difference from `at`.
    Gaussian(Slope at, Symmetric precision, Slope gradient = {}) {
        // Cholesky's factor; rounding must not make it degenerate.
        constexpr float kThinnest = 1e-6f;
        inv11_ = 1 / std::sqrt(precision.xx);
        l21_ = precision.xy * inv11_;
        inv22_ = 1 / std::sqrt(std::max(precision.yy - l21_ * l21_, kThinnest * precision.yy));
        const float x = gradient.x * inv11_;
        mean_ = at + FromStandard({x, (gradient.y - l21_ * x) * inv22_});
    }

    /// False where the parameters that it was made from were not numbers: then it must not be used.
    bool IsValid() const {
        return inv11_ > 0 && inv22_ > 0 && std::isfinite(inv11_ + inv22_ + std::abs(l21_)) &&
               std::isfinite(mean_.x + mean_.y);
    }
    Slope Mean() const { return mean_; }
    struct Sample {
        Slope m;
        float density;
    };
    Sample Draw(Rng& rng) const {
        const Point2 u = rng.Uniform2D();
        const float radius = std::sqrt(-2 * std::log(1 - u.x)), phi = 2 * Pi * u.y;
        // exp(-radius^2/2) is the number that made the radius.
        return {mean_ + FromStandard({radius * std::cos(phi), radius * std::sin(phi)}), Peak() * (1 - u.x)};
    }
    /// Per unit of area in the plane of slopes.
    float Density(Slope m) const {
        const Slope d = m - mean_;
        const float a = d.x / inv11_ + l21_ * d.y, b = d.y / inv22_;
        return Peak() * std::exp(-0.5f * (a * a + b * b));
    }

  private:
    /// The transposed factor's inverse times a vector.
    Slope FromStandard(Slope v) const {
        const float y = v.y * inv22_;
        return {(v.x - l21_ * y) * inv11_, y};
    }
    float Peak() const { return Inv2Pi / (inv11_ * inv22_); }

    Slope mean_;
    float inv11_ = 1, l21_ = 0, inv22_ = 1;
};

}  // namespace lacquer::layered::slopes
