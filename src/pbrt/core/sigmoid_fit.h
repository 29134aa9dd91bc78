#pragma once

/// Fits the table that turns RGB colours into smooth spectra by a sigmoid of a quadratic polynomial.
/// Source: W. Jakob and J. Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling",
/// Computer Graphics Forum 38(2), 2019 [Jakob and Hanika 2019].
///
/// The spectrum of coefficients (c0, c1, c2) at the wavelength l, in nm, is
///     s(l) = 1/2 + x / (2 sqrt(1 + x^2)),    x = c0 l^2 + c1 l + c2,
/// hence always between 0 and 1. `src/cmd/bake_rgb_tables.cpp` makes one table for each colour space during
/// the build and writes them to one file.
///
/// File of tables: four records, for sRGB, DCI-P3, Rec2020 and ACES2065-1 in this order. No header; each
/// number is a 32-bit IEEE 754 float, little-endian. A record is 64 z nodes, ascending from 0 to 1, followed
/// by the coefficients [3 l][64 z][64 y][64 x][3 c], c fastest, where for a colour rgb
///     l    index of the largest component,
///     z    the value of that component, at the z nodes,
///     y    rgb[(l + 2) % 3] / z, at j / 63,
///     x    rgb[(l + 1) % 3] / z, at i / 63,
///     c    c0 [1/nm^2], c1 [1/nm], c2 [1].
/// Between nodes the coefficients, not the spectra, are interpolated (trilinearly).

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace lacquer {

using FitVec3 = std::array<double, 3>;
/// Row-major: m[row][column].
using FitMat3 = std::array<FitVec3, 3>;

/// Number of nodes along each of the axes x, y, z of a table.
inline constexpr int kSigmoidTableRes = 64;

/// Number of floats that hold the coefficients of one table.
inline constexpr std::size_t kSigmoidTableSize =
    std::size_t{3} * kSigmoidTableRes * kSigmoidTableRes * kSigmoidTableRes * 3;

/// What the fit needs to know of one colour space. The three spans have one length; the caller keeps them.
struct SigmoidFitProblem {
    /// Wavelengths [nm], equidistant, ascending, at least 4 of them. Colours are plain sums over them, so
    /// that a renderer that adds up 1 nm steps passes the integers 360..830.
    std::span<const double> nm;
    /// Colour matching functions (x, y, z) at `nm`, in any common scale.
    std::span<const FitVec3> observer;
    /// Relative spectral power of the space's illuminant at `nm`, in any scale.
    std::span<const double> illuminant;
    /// RGB to XYZ; (1, 1, 1) maps to the illuminant's XYZ with Y = 1.
    FitMat3 xyzFromRgb;
};

/// A fitted table and how good it is.
struct SigmoidTable {
    /// Values of z at the nodes k / 63, see SigmoidTableZNode().
    std::array<float, kSigmoidTableRes> zNodes{};
    /// Coefficients, laid out as said at the top of this file; kSigmoidTableSize floats.
    std::vector<float> coefficients;
    /// Largest CIELAB distance between the colour of a node and that of its spectrum. Large in wide spaces,
    /// which hold colours that no reflectance has; in sRGB a few, for saturated colours near black.
    double maxResidual = 0;
    /// Number of nodes of z > 0 whose residual is above kSigmoidResidualReached.
    int numUnreached = 0;
};

/// CIELAB distance up to which a colour counts as reached, a small part of what an eye can tell.
inline constexpr double kSigmoidResidualReached = 0.1;

/// Position of the k-th z node, smoothstep(smoothstep(k / 63)): dense at both ends, where the coefficients
/// change fast.   @param k  0..63
double SigmoidTableZNode(int k);

/// Value of a spectrum.
/// @param c   coefficients in nm, see the top of this file   @param nm  wavelength [nm]
/// @return    0..1
double EvaluateSigmoid(const FitVec3& c, double nm);

/// RGB to XYZ from the xy chromaticities of the red, green and blue primaries and of the white point, so that
/// (1, 1, 1) maps to the white point at Y = 1. The primaries must span a triangle.
FitMat3 XyzFromRgbMatrix(const std::array<std::array<double, 2>, 3>& primaries,
                         const std::array<double, 2>& white);

/// Fits a table: Gauss-Newton with Levenberg-Marquardt damping on the CIELAB difference under the space's
/// illuminant, each column warm-started along z. Unreachable colours get the nearest spectrum found.
/// Costs about a million fits of 4 or 5 steps. Deterministic: the result does not depend on `numThreads`.
/// @param numThreads  threads to use, >= 1
/// Source     [Jakob and Hanika 2019] sec. 3 and 4; layout and z nodes as in pbrt-v4's tables
SigmoidTable FitSigmoidTable(const SigmoidFitProblem& problem, int numThreads);

}  // namespace lacquer
