// Random numbers of ensembles, in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bulk/conventions.h"
#include "pbrt/core/rng.h"

namespace lacquer::bulk {

/// One stream for each realisation, seeded by Hash(seed of the file, number of the realisation).
class Random {
  public:
    explicit Random(uint64_t seed) : rng_(seed) {}
    /// In [0, 1), with 53 bits.
    double Uniform() { return double(rng_.NextBits() >> 11) * 0x1p-53; }
    double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
    size_t Index(size_t count) { return std::min(count - 1, size_t(Uniform() * double(count))); }
    double Normal() {
        const double r = std::sqrt(-2 * std::log(1 - Uniform()));
        return r * std::cos(2 * std::numbers::pi * Uniform());
    }
    Point InCube(double low, double high) {
        const double x = Uniform(low, high), y = Uniform(low, high);
        return {x, y, Uniform(low, high)};
    }
    Point InBall(double radius) {
        while (true) {
            const Point p = InCube(-radius, radius);
            if (p.squaredNorm() <= radius * radius) return p;
        }
    }
    Point NormalPoint() {
        const double x = Normal(), y = Normal();
        return {x, y, Normal()};
    }
    /// Uniform over all rotations: by a unit quaternion, two points on circles with radii that share the
    /// unit.
    Eigen::Matrix3d Rotation();
    /// About z, and as often upside down as not.
    Eigen::Matrix3d RotationKeepingAxis() {
        const double phi = 2 * std::numbers::pi * Uniform(), up = Uniform() < 0.5 ? -1. : 1.;
        Eigen::Matrix3d r;
        r << std::cos(phi), -up * std::sin(phi), 0, std::sin(phi), up * std::cos(phi), 0, 0, 0, up;
        return r;
    }

  private:
    Rng rng_;
};

inline Eigen::Matrix3d Random::Rotation() {
    const double u = Uniform(), a = 2 * std::numbers::pi * Uniform(), b = 2 * std::numbers::pi * Uniform();
    const double s = std::sqrt(1 - u), t = std::sqrt(u);
    // A unit quaternion (w, x, y, z), as a matrix.
    const double x = s * std::sin(a), y = s * std::cos(a), z = t * std::sin(b), w = t * std::cos(b);
    Eigen::Matrix3d r;
    r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
    return r;
}

}  // namespace lacquer::bulk
