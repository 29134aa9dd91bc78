// Warps of uniform numbers. Each comes as a set: Sample, Pdf, Invert.
#pragma once

#include <span>
#include <vector>

#include "pbrt/core/math.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Index drawn with probability weights[i] / sum, u in [0,1). `pmf` gets that probability, `remapped` a fresh
/// uniform number made from what is left of u. -1 if all weights are zero.
int SampleDiscrete(std::span<const float> weights, float u, float* pmf = nullptr, float* remapped = nullptr);

/// x in [0,1] with density proportional to the line from a to b.
inline float SampleLinear(float u, float a, float b) {
    if (u == 0 && a == 0) return 0;
    const float x = u * (a + b) / (a + std::sqrt(Lerp(u, a * a, b * b)));
    return std::min(x, OneMinusEpsilon);
}
inline float PdfLinear(float x, float a, float b) {
    return x < 0 || x > 1 ? 0.f : 2 * Lerp(x, a, b) / (a + b);
}
inline float InvertLinear(float x, float a, float b) { return x * (a * (2 - x) + b * x) / (a + b); }

/// x in [-r, r] with density proportional to r - |x|.
float SampleTent(float u, float r);
float PdfTent(float x, float r);
float InvertTent(float x, float r);

/// Uniform point of the unit disk; keeps neighbourhoods [Shirley and Chiu 1997].
inline Point2 SampleUniformDiskConcentric(Point2 u) {
    const Point2 offset = 2.f * u - Point2(1, 1);
    if (offset.x == 0 && offset.y == 0) return {0, 0};
    float r, turn;
    if (std::abs(offset.x) > std::abs(offset.y)) {
        r = offset.x;
        turn = 0.125f * (offset.y / offset.x);
    } else {
        r = offset.y;
        turn = 0.25f - 0.125f * (offset.x / offset.y);
    }
    const auto [sin, cos] = SinCosOfTurn(turn);
    return r * Point2(cos, sin);
}
inline float PdfUniformDisk() { return InvPi; }
Point2 InvertUniformDiskConcentric(Point2 p);
/// Uniform point of the unit disk, u.x to radius and u.y to angle.
Point2 SampleUniformDiskPolar(Point2 u);
Point2 InvertUniformDiskPolar(Point2 p);

/// Direction in the hemisphere z >= 0 with density cos(theta)/pi.
inline Vec3 SampleCosineHemisphere(Point2 u) {
    const Point2 d = SampleUniformDiskConcentric(u);
    return {d.x, d.y, SafeSqrt(1 - d.x * d.x - d.y * d.y)};
}
inline float PdfCosineHemisphere(float cosTheta) { return cosTheta > 0 ? cosTheta * InvPi : 0.f; }
inline Point2 InvertCosineHemisphere(Vec3 w) { return InvertUniformDiskConcentric({w.x, w.y}); }

/// Uniform direction in the hemisphere z >= 0; u.x is the cosine.
Vec3 SampleUniformHemisphere(Point2 u);
inline float PdfUniformHemisphere() { return Inv2Pi; }
Point2 InvertUniformHemisphere(Vec3 w);

/// Uniform direction; cos(theta) = 1 - 2 u.x.
Vec3 SampleUniformSphere(Point2 u);
inline float PdfUniformSphere() { return Inv4Pi; }
Point2 InvertUniformSphere(Vec3 w);

/// Uniform direction in the cone about +z with the given cosine of its half angle.
Vec3 SampleUniformCone(Point2 u, float cosThetaMax);
/// `oneMinusCosThetaMax` is passed by itself, for it loses its digits in narrow cones.
inline float PdfUniformCone(float oneMinusCosThetaMax) { return 1 / (2 * Pi * oneMinusCosThetaMax); }
Point2 InvertUniformCone(Vec3 w, float cosThetaMax);

/// Barycentric coordinates (b0, b1, 1 - b0 - b1) of a uniform point of a triangle [Heitz 2019].
inline Vec3 SampleUniformTriangle(Point2 u) {
    float b0, b1;
    if (u.x < u.y) {
        b0 = u.x / 2;
        b1 = u.y - b0;
    } else {
        b1 = u.y / 2;
        b0 = u.x - b1;
    }
    return {b0, b1, 1 - b0 - b1};
}
Point2 InvertUniformTriangle(Vec3 b);

/// Point of [0,1]^2 with density proportional to the bilinear function with corners w = {(0,0), (1,0), (0,1),
/// (1,1)}.
Point2 SampleBilinear(Point2 u, std::span<const float, 4> w);
float PdfBilinear(Point2 p, std::span<const float, 4> w);
Point2 InvertBilinear(Point2 p, std::span<const float, 4> w);

/// Piecewise constant density on [min, max] from non-negative values; uniform if they are all zero.
class PiecewiseConstant1D {
  public:
    PiecewiseConstant1D() = default;
    explicit PiecewiseConstant1D(std::span<const float> values, float min = 0, float max = 1);
    int Size() const { return int(values_.size()); }
    /// Integral of the values over [min, max].
    float Integral() const { return integral_; }
    float Sample(float u, float* pdf = nullptr, int* cell = nullptr) const;
    float Pdf(float x) const;
    /// u with Sample(u) = x; x in [min, max].
    float Invert(float x) const;

  private:
    friend class PiecewiseConstant2D;
    int CellOf(float x) const;
    int CellAt(float u) const;
    std::vector<float> values_, cdf_;
    std::vector<int> guide_;  ///< cell at u = k/size, so that few steps lead to the right one
    float min_ = 0, max_ = 1, integral_ = 0;
    float cellWidth_ = 1, cellsPerUnit_ = 1;
};

/// The same on a rectangle, values in rows (x fastest).
class PiecewiseConstant2D {
  public:
    PiecewiseConstant2D() = default;
    PiecewiseConstant2D(std::span<const float> values, int nx, int ny, Point2 min = Point2(0),
                        Point2 max = Point2(1));
    Int2 Resolution() const {
        return {conditional_.empty() ? 0 : conditional_[0].Size(), int(conditional_.size())};
    }
    float Integral() const { return marginal_.Integral(); }
    Point2 Sample(Point2 u, float* pdf = nullptr, Int2* cell = nullptr) const;
    float Pdf(Point2 p) const;
    Point2 Invert(Point2 p) const;

  private:
    Point2 min_{0}, max_{1};
    std::vector<PiecewiseConstant1D> conditional_;
    PiecewiseConstant1D marginal_;
};

/// Draws indices with given probabilities in constant time [Vose 1991]. Uniform if all weights are zero; an
/// empty table draws -1.
class AliasTable {
  public:
    AliasTable() = default;
    explicit AliasTable(std::span<const float> weights);
    int Size() const { return int(bins_.size()); }
    int Sample(float u, float* pmf = nullptr, float* remapped = nullptr) const;
    float Pmf(int i) const { return bins_[size_t(i)].p; }

  private:
    struct Bin {
        float q = 0;  ///< chance to stay
        float p = 0;  ///< probability of this index
        int alias = -1;
    };
    std::vector<Bin> bins_;
};

}  // namespace lacquer
