// Gaussians and small mixtures of them over the slopes of directions, and their products.
//
// The slope of a unit direction w is (x/z, y/z). A direction and its opposite share it, so it goes with the
// sign of z, which in a stack of layers the order of the interfaces fixes [Xia et al. 2020, sec. 5.1].
#pragma once

#include <array>

#include "pbrt/core/math.h"
#include "pbrt/core/vec.h"

namespace lacquer::gaussfit {

/// Slope of w; w.z must not be 0.
inline Point2 SlopeOf(Vec3 w) { return {w.x / w.z, w.y / w.z}; }
/// The unit direction of a slope whose z has the sign of `side` (not 0).
inline Vec3 DirectionOfSlope(Point2 slope, float side) {
    const float z = std::copysign(1 / std::sqrt(1 + slope.x * slope.x + slope.y * slope.y), side);
    return {slope.x * z, slope.y * z, z};
}
/// Area of slopes per solid angle of w, 1/|cos|^3: turns a density over slopes into one over solid angle.
inline float SlopePerSolidAngle(Vec3 w) { return 1 / std::abs(w.z * w.z * w.z); }

/// A Gaussian over slopes: exp(-(s - mean)' P (s - mean) / 2), with P its precision, the inverse of the
/// covariance. P is positive definite.
struct Gaussian2 {
    float meanX = 0, meanY = 0;
    float xx = 1, xy = 0, yy = 1;  ///< P

    /// P = L L', L lower triangular [Xia et al. 2020] eq. 17. Where rounding took the definiteness, the
    /// corner of L becomes small: Draw() and Pdf() both go by L, so they agree whatever happened to P.
    struct Factor {
        float xx, yx, yy;
        /// Square root of the determinant of P.
        float Volume() const { return xx * yy; }
    };
    Factor Factorize() const {
        const float root = std::sqrt(xx), side = xy / root;
        return {root, side, std::sqrt(std::max(yy - side * side, 1e-6f * yy))};
    }
    /// Density [per unit of slope area].
    float Pdf(Point2 slope) const {
        const Factor l = Factorize();
        const float dx = slope.x - meanX, dy = slope.y - meanY;
        const float a = l.xx * dx + l.yx * dy, b = l.yy * dy;
        return l.Volume() * Inv2Pi * std::exp(-0.5f * (a * a + b * b));
    }
    /// The slope of a point in the plane's standard normal distribution: solves L' d = normal.
    Point2 FromStandard(Point2 normal) const {
        const Factor l = Factorize();
        const float dy = normal.y / l.yy;
        return {meanX + (normal.x - l.yx * dy) / l.xx, meanY + dy};
    }
    /// A slope drawn from it [Box and Muller 1958]. @param u  uniform in [0,1)^2
    Point2 Draw(Point2 u) const {
        const float radius = std::sqrt(-2 * std::log(1 - u.x)), angle = 2 * Pi * u.y;
        return FromStandard({radius * std::cos(angle), radius * std::sin(angle)});
    }
};

/// The normalised product of two Gaussians [Xia et al. 2020] eq. A.1 to A.3.
inline Gaussian2 Multiply(const Gaussian2& a, const Gaussian2& b) {
    Gaussian2 g{0, 0, a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
    // The mean seen from a's: with d = mean_b - mean_a, P mean = P_b d, which keeps its digits where both
    // means are far from 0 and close to each other.
    const float dx = b.meanX - a.meanX, dy = b.meanY - a.meanY;
    const Gaussian2::Factor l = g.Factorize();
    const float u = (b.xx * dx + b.xy * dy) / l.xx, v = (b.xy * dx + b.yy * dy - l.yx * u) / l.yy;
    const float my = v / l.yy;
    g.meanX = a.meanX + (u - l.yx * my) / l.xx;
    g.meanY = a.meanY + my;
    return g;
}
/// Logarithm of what the product of the densities of a and b is larger by than that of `product`, without the
/// factor 1/(2 pi) [Xia et al. 2020, eq. A.4]; very negative for Gaussians that are far apart.
inline float LogScaleOfProduct(const Gaussian2& a, const Gaussian2& b, const Gaussian2& product) {
    // s = N(mean_a | mean_b, Sigma_a + Sigma_b): its determinant is that of P over those of P_a and P_b, its
    // exponent what completing the square leaves.
    const float dx = b.meanX - a.meanX, dy = b.meanY - a.meanY;
    const float px = b.xx * dx + b.xy * dy, py = b.xy * dx + b.yy * dy;
    const float rx = b.meanX - product.meanX, ry = b.meanY - product.meanY;
    return -0.5f * std::max(0.f, rx * px + ry * py) +
           std::log(a.Factorize().Volume() * b.Factorize().Volume() / product.Factorize().Volume());
}

/// A mixture of at most kMax Gaussians; the weights are positive and sum to 1.
template <int kMax>
struct GaussianMixtureOf {
    std::array<Gaussian2, kMax> parts;
    std::array<float, kMax> weights{};
    int count = 0;

    GaussianMixtureOf() = default;
    explicit GaussianMixtureOf(const Gaussian2& single) : count(1) {
        parts[0] = single;
        weights[0] = 1;
    }

    /// Density [per unit of slope area].
    float Pdf(Point2 slope) const {
        if (count == 1) return parts[0].Pdf(slope);
        float sum = 0;
        for (int i = 0; i < count; ++i) sum += weights[size_t(i)] * parts[size_t(i)].Pdf(slope);
        return sum;
    }
    /// A slope drawn from it; u.x chooses the part, too. @param u  uniform in [0,1)^2
    Point2 Draw(Point2 u) const {
        int i = 0;
        while (i + 1 < count && u.x >= weights[size_t(i)]) u.x -= weights[size_t(i++)];
        if (count > 1) u.x = std::clamp(u.x / weights[size_t(i)], 0.f, OneMinusEpsilon);
        return parts[size_t(i)].Draw(u);
    }
};

/// What approximates one lobe of an interface.
using GaussianMixture = GaussianMixtureOf<2>;
/// The normalised product of two of them.
using GaussianMixtureProduct = GaussianMixtureOf<4>;

inline GaussianMixtureProduct Multiply(const GaussianMixture& a, const GaussianMixture& b) {
    GaussianMixtureProduct product;
    if (a.count == 1 && b.count == 1) return GaussianMixtureProduct(Multiply(a.parts[0], b.parts[0]));
    std::array<float, 4> exponents{};
    float largest = -Infinity;
    for (int i = 0; i < a.count; ++i) {
        for (int j = 0; j < b.count; ++j) {
            const size_t k = size_t(product.count++);
            const Gaussian2 &partA = a.parts[size_t(i)], &partB = b.parts[size_t(j)];
            product.parts[k] = Multiply(partA, partB);
            product.weights[k] = a.weights[size_t(i)] * b.weights[size_t(j)];
            exponents[k] = LogScaleOfProduct(partA, partB, product.parts[k]);
            largest = std::max(largest, exponents[k]);
        }
    }
    // Relative to the largest one: all may be too small for a float.
    float sum = 0;
    for (size_t k = 0; k < size_t(product.count); ++k)
        sum += product.weights[k] *= std::exp(exponents[k] - largest);
    for (size_t k = 0; k < size_t(product.count); ++k) product.weights[k] /= sum;
    return product;
}

}  // namespace lacquer::gaussfit
