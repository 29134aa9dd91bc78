// Reflection straight back to a light at the camera, for one pixel. There the direction to the camera is the
// half vector, and light meets its facets straight on. Templates, so that tests can differentiate them with
// Ceres' Jets.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace lacquer::estimate {

/// With masking or without.
enum class Brdf {
    Smith,   ///< what Lacquer renders: D G F / (4 cos^2), G = 1 / (1 + 2 Lambda) [Walter et al. 2007]
    Chapter  ///< D F / (4 cos^2) of [Guo et al. 2020]
};

/// Smallest cosine between the normal and the direction to the camera.
constexpr double kMinCosine = 1e-4;
/// Reflectance at normal incidence of dielectrics: an index of 1.5.
constexpr double kDielectricF0 = 0.04;

/// cos f of a lobe with F0 = 1: c D(c) G(c) / (4 c^2), D = 1 / (pi a ((1 - c^2) / a + c^2)^2), a = alpha^2.
/// @param c  cosine, in [kMinCosine, 1]
template <class T>
T BackLobe(Brdf brdf, const T& c, const T& a) {
    using std::sqrt;
    const T c2 = c * c, u = 1.0 - c2 + a * c2;
    const T d = a / ((4 * std::numbers::pi) * u * u);
    return brdf == Brdf::Chapter ? T(d / c) : T(d / sqrt(c2 + a * (1.0 - c2)));
}

/// The same for anisotropic microfacets, by the squares of the components of the direction along tangent,
/// bitangent and normal.
/// @param alphaX, alphaY  as distributions take them
template <class T>
T AnisotropicBackLobe(Brdf brdf, const T& hx2, const T& hy2, const T& c2, const T& alphaX, const T& alphaY) {
    using std::sqrt;
    const T s = hx2 / (alphaX * alphaX) + hy2 / (alphaY * alphaY) + c2;
    const T d = 1.0 / ((4 * std::numbers::pi) * alphaX * alphaY * s * s);
    return brdf == Brdf::Chapter ? T(d / sqrt(c2))
                                 : T(d / sqrt(c2 + alphaX * alphaX * hx2 + alphaY * alphaY * hy2));
}

/// Where a point of the sample lies, from the axis of the camera [cm].
template <class T>
struct FromAxis {
    T x, y;
    double distance;  ///< of the camera from the sample
    T SquaredDistance() const { return x * x + y * y + distance * distance; }
};

/// Cosine between the normal of a surface with these slopes and the direction to the camera, at least
/// kMinCosine.
template <class T>
T CosineAt(const FromAxis<T>& at, const T& slopeX, const T& slopeY) {
    using std::sqrt;
    const T c = (at.x * slopeX + at.y * slopeY + at.distance) /
                sqrt(at.SquaredDistance() * (1.0 + slopeX * slopeX + slopeY * slopeY));
    return c > kMinCosine ? c : T(kMinCosine);
}

/// cos f of a dielectric in each channel.
template <class T>
std::array<T, 3> DielectricPixel(Brdf brdf, const FromAxis<T>& at, const T& slopeX, const T& slopeY,
                                 const T& roughness, const std::array<T, 3>& albedo) {
    const T c = CosineAt(at, slopeX, slopeY), r2 = roughness * roughness;
    const T lobe = kDielectricF0 * BackLobe(brdf, c, T(r2 * r2)), diffuse = c / std::numbers::pi;
    return {T(albedo[0] * diffuse + lobe), T(albedo[1] * diffuse + lobe), T(albedo[2] * diffuse + lobe)};
}

/// cos f of a metal with F0 = 1. The tangent is x, made perpendicular to the normal.
template <class T>
T MetalPixel(Brdf brdf, const FromAxis<T>& at, const T& slopeX, const T& slopeY, const T& roughnessX,
             const T& roughnessY) {
    const T m = 1.0 + slopeY * slopeY, n2 = m + slopeX * slopeX, d2 = at.SquaredDistance();
    const T tx = at.y * slopeX * slopeY + at.distance * slopeX - at.x * m, ty = at.distance * slopeY - at.y;
    const T c = CosineAt(at, slopeX, slopeY);
    return AnisotropicBackLobe(brdf, T(tx * tx / (d2 * n2 * m)), T(ty * ty / (d2 * m)), T(c * c),
                               T(roughnessX * roughnessX), T(roughnessY * roughnessY));
}

}  // namespace lacquer::estimate
