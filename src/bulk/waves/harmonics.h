// Vector spherical harmonics, plane waves and far fields.
#pragma once

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// C_nm and B_nm in one direction, each a column along theta^ and one along phi^; rows by HarmonicIndex().
/// Orthonormal over the sphere, with Condon-Shortley's phase; regular at the poles.
struct VectorHarmonics {
    Eigen::MatrixX2cd c, b;
};
VectorHarmonics HarmonicsAt(int degree, Direction direction);

/// Regular coefficients about the origin of exp(i n.r) times theta^ (column 0) and phi^ (column 1): 2 L(L+2)
/// rows.
Eigen::MatrixX2cd PlaneWave(int degree, Direction n);

/// F = FarField(...) * (outgoing coefficients about the origin), E_sca -> F exp(ir)/r: rows theta^ and phi^.
/// For a sphere and light along z, F_theta = i S_2 and F_phi = i S_1 of Bohren and Huffman.
Eigen::Matrix2Xcd FarField(int degree, Direction s);

/// Spherical Bessel functions j_n (x >= 0) and y_n (x > 0), n = 0 ... degree.
Eigen::VectorXd SphericalBesselJ(int degree, double x);
Eigen::VectorXd SphericalBesselY(int degree, double x);

/// Electric field at `point` of waves with these coefficients about the origin, in Cartesian components. For
/// tests and plots. @param isRegular  of j_n, not of h_n
Eigen::Vector3cd FieldAt(const Eigen::VectorXcd& coefficients, int degree, const Point& point,
                         bool isRegular);

}  // namespace lacquer::bulk
