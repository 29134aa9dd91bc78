// What a texel of the maps shows in a flash photograph [Guo et al. 2020b]: a Lambertian lobe under a GGX lobe
// with a coloured reflectance, lit by one point light. Templates over the number type: double, dual
// numbers, or those of a library that differentiates.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "capture/maps.h"
#include "capture/views.h"

namespace lacquer::capture {

/// What the model adds to its denominators. Not harmless in D: it holds lobes with an alpha below 0.035 down.
inline constexpr double kModelEpsilon = 1e-6;
/// Stored values stand for linear ones, and photographs show linear ones, by this power.
inline constexpr double kModelGamma = 2.2;

/// The nine stored numbers of a texel, in the order of the channels.
template <class T>
using StoredTexel = std::array<T, kNumChannels>;

/// The same as what they stand for.
template <class T>
struct Texel {
    std::array<T, 3> albedo, normal, specular;  ///< the normal is a unit vector
    T alpha;
};

/// Directions at a texel, unit vectors, and the distance to the light.
struct TexelGeometry {
    Point toCamera, toLight, half;
    double distance;  ///< [cm]
};

/// x of a column and y of a row of size x size texels on a square with that edge [cm].
inline double TexelX(int column, int size, double edge) { return ((column + 0.5) / size - 0.5) * edge; }
inline double TexelY(int row, int size, double edge) { return -TexelX(row, size, edge); }

template <class T>
T ClampTo(const T& x, double low, double high) {
    return x < low ? T(low) : x > high ? T(high) : x;
}

template <class T>
T Dot3(const std::array<T, 3>& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A linear value in [0,1] by a stored one in [-1,1].
template <class T>
T LinearOf(const T& stored) {
    using std::pow;
    return pow(T((ClampTo(stored, -1, 1) + 1.0) * 0.5), kModelGamma);
}
/// The stored value that stands for a linear one. @param linear  clamped to [0,1]
inline double StoredOf(double linear) { return 2 * std::pow(ClampTo(linear, 0, 1), 1 / kModelGamma) - 1; }

template <class T>
Texel<T> Decode(const StoredTexel<T>& t) {
    using std::sqrt;
    Texel<T> texel;
    for (size_t c = 0; c < 3; ++c) {
        texel.albedo[c] = LinearOf(t[kAlbedo + c]);
        texel.specular[c] = LinearOf(t[kSpecular + c]);
    }
    const T roughness = LinearOf(t[kRoughness]);
    texel.alpha = roughness * roughness;
    const T x = ClampTo(t[kNormal], -1, 1), y = ClampTo(t[kNormal + 1], -1, 1);
    const T xy2 = x * x + y * y, z2 = 1.0 - ClampTo(xy2, 0, 1 - kModelEpsilon);
    const T scale = 1.0 / sqrt(T(xy2 + z2));
    texel.normal = {T(x * scale), T(y * scale), T(sqrt(z2) * scale)};
    return texel;
}

/// @param x, y  of the texel [cm]; both points must lie above it
inline TexelGeometry GeometryAt(double x, double y, const Point& camera, const Point& light) {
    const auto scaled = [](const Point& p, double s) { return Point{p[0] * s, p[1] * s, p[2] * s}; };
    const auto length = [](const Point& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); };
    const Point v{camera[0] - x, camera[1] - y, camera[2]}, l{light[0] - x, light[1] - y, light[2]};
    TexelGeometry g;
    g.distance = length(l);
    g.toCamera = scaled(v, 1 / length(v));
    g.toLight = scaled(l, 1 / g.distance);
    const Point sum{g.toCamera[0] + g.toLight[0], g.toCamera[1] + g.toLight[1], g.toCamera[2] + g.toLight[2]};
    g.half = scaled(sum, 1 / length(sum));
    return g;
}

/// How far F is on its way from the reflectance at normal incidence to 1 [Karis 2013].
/// @param vh  cosine between a direction and the half vector
inline double SchlickWeight(double vh) { return std::exp2((-5.55473 * vh - 6.98316) * vh); }

/// D G / (4 cos cos) of facets that reflect everything, by cosines in [0,1].
template <class T>
T FacetLobe(const T& nv, const T& nl, const T& nh, const T& alpha) {
    const T alpha2 = alpha * alpha, u = nh * nh * (alpha2 - 1.0) + 1.0;
    const T D = alpha2 / (std::numbers::pi * u * u + kModelEpsilon);
    const T k = alpha * 0.5 + kModelEpsilon;
    const T G = nv / (nv * (1.0 - k) + k) * (nl / (nl * (1.0 - k) + k));
    return D * G / (4.0 * nv * nl + kModelEpsilon);
}

/// Linear light that reaches the camera. @param power  of the light [cm^2]
template <class T>
std::array<T, 3> LinearValue(const Texel<T>& texel, const TexelGeometry& g,
                             const std::array<double, 3>& power) {
    const auto cosine = [&](const Point& w) {
        const T c = Dot3(texel.normal, w);
        return c < 0.0 ? T(0.0) : c;
    };
    const T nv = cosine(g.toCamera), nl = cosine(g.toLight);
    const T lobe = FacetLobe(nv, nl, cosine(g.half), texel.alpha);
    const double vh =
        std::fmax(0, g.toCamera[0] * g.half[0] + g.toCamera[1] * g.half[1] + g.toCamera[2] * g.half[2]);
    const double weight = SchlickWeight(vh);
    std::array<T, 3> value;
    for (size_t c = 0; c < 3; ++c) {
        const T& s = texel.specular[c];
        const T F = s + (1.0 - s) * weight;
        const T f = texel.albedo[c] * (1.0 - s) * std::numbers::inv_pi + lobe * F;
        value[c] = f * nl * (power[c] / (g.distance * g.distance));
    }
    return value;
}

/// What a photograph of the model shows for a linear value.
template <class T>
T EncodedOf(const T& linear) {
    using std::pow;
    return pow(ClampTo(linear, kModelEpsilon, 1), 1 / kModelGamma);
}

/// The three encoded values of a texel in a photograph, in [0,1].
template <class T>
std::array<T, 3> EncodedValue(const StoredTexel<T>& stored, const TexelGeometry& g,
                              const std::array<double, 3>& power) {
    const std::array<T, 3> linear = LinearValue(Decode(stored), g, power);
    return {EncodedOf(linear[0]), EncodedOf(linear[1]), EncodedOf(linear[2])};
}

}  // namespace lacquer::capture
