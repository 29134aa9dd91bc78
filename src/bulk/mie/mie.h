// One sphere in a plane wave: Lorenz-Mie theory, for homogeneous spheres and for spheres of several layers.
#pragma once

#include <span>
#include <vector>

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// Degree that the series of an isolated sphere needs, at least 3 [Wiscombe 1980].
int MieDegree(double x);
/// Degree that an expansion about one origin needs to hold fields of sources within `radius` to `digits`
/// digits [Chew et al. 2001, sec. 3.4].
int FieldDegree(double radius, double digits);

/// One layer of a sphere.
struct SphereLayer {
    double x = 0;  ///< outer radius times k
    Complex index = 1;
};

/// a_n (electric) and b_n (magnetic), n = 1 ... Degree() at index n - 1 [Bohren and Huffman 1983, eq. 4.53].
struct MieCoefficients {
    std::vector<Complex> a, b;
    int Degree() const { return int(a.size()); }
};
/// @param x, m  size parameter > 0, index relative to the host, Im m >= 0
MieCoefficients MieOfSphere(double x, Complex m, int degree);
/// @param layers  from the core outwards, x growing. One layer gives MieOfSphere(). Cost O(layers degree)
MieCoefficients MieOfLayers(std::span<const SphereLayer> layers, int degree);

/// Cross sections over the geometric one, pi x^2, and the mean cosine.
struct MieEfficiencies {
    double extinction = 0, scattering = 0, backscattering = 0, g = 0;
    double Absorption() const { return extinction - scattering; }
};
MieEfficiencies EfficienciesOf(const MieCoefficients& coefficients, double x);

/// S_1 (perpendicular to the scattering plane) and S_2 (in it) [Bohren and Huffman 1983, eq. 4.74].
struct MieAmplitudes {
    Complex s1, s2;
    /// S_11 of unpolarised light: its integral over the sphere of directions is k^2 C_sca.
    double Intensity() const { return 0.5 * (std::norm(s1) + std::norm(s2)); }
};
MieAmplitudes AmplitudesAt(const MieCoefficients& coefficients, double cosTheta);

}  // namespace lacquer::bulk
