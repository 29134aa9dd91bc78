// What all of bulk agrees on: units, signs, and the order of coefficients.
//
// Time goes as exp(-i omega t), so outgoing waves are h^(1) and absorption is a positive imaginary part of an
// index. Indices are relative to the host, m = n_particle / n_host. All lengths are multiplied by k = 2 pi
// n_host / lambda (lambda in vacuum): a radius is a size parameter x, a cross section is k^2 C. Lengths with
// units enter and leave in the module's readers and writers only.
//
// The polarisation basis of a direction (theta, phi) is theta^ = (cos theta cos phi, cos theta sin phi, -sin
// theta) and phi^ = (-sin phi, cos phi, 0), at the poles with the phi that is given. A field of coefficients
// has two parts of L(L+2) numbers, those of M_nm = z_n C_nm first and then those of N_nm = curl M_nm / k,
// with orthonormal vector harmonics (waves/harmonics.h); the sum of the squares of outgoing coefficients
// about one origin is k^2 C_sca.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>

namespace lacquer::bulk {

using Complex = std::complex<double>;
using Point = Eigen::Vector3d;  ///< times k

/// Number of pairs (n, m) with 1 <= n <= degree.
constexpr int NumHarmonics(int degree) { return degree * (degree + 2); }
/// Place of (n, m) among them.
constexpr int HarmonicIndex(int n, int m) { return n * (n + 1) + m - 1; }
constexpr double ParitySign(int n) { return n % 2 == 0 ? 1. : -1.; }
/// i^n.
inline Complex PowerOfI(int n) {
    constexpr Complex kPowers[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    return kPowers[((n % 4) + 4) % 4];
}

/// A direction by its angles in radians; theta from +z.
struct Direction {
    double theta = 0, phi = 0;
    Point Vector() const {
        return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
    }
};

}  // namespace lacquer::bulk
