// What a smooth boundary between two media reflects and where it refracts to.
#pragma once

#include <optional>

#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Reflectance of an unpolarised ray at a smooth dielectric boundary; 1 under total internal reflection.
/// @param cosTheta_i  cosine of incidence in [-1,1]; negative: the ray comes from the inside
/// @param eta         index inside over index outside, > 0 (whatever the sign of the cosine)
inline float FresnelDielectric(float cosTheta_i, float eta) {
    if (cosTheta_i < 0) {
        cosTheta_i = -cosTheta_i;
        eta = 1 / eta;
    }
    const float c = std::min(cosTheta_i, 1.f);
    // Snell's law, with 1 - c^2 as a product so that it keeps its digits near normal incidence.
    const float cos2Theta_t = 1 - (1 - c) * (1 + c) / (eta * eta);
    if (!(cos2Theta_t > 0)) return 1;
    const float t = std::sqrt(cos2Theta_t);
    const float parallel = (eta * c - t) / (eta * c + t);
    const float perpendicular = (c - eta * t) / (c + eta * t);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/// Reflectance of an unpolarised ray at a smooth conductor with complex index eta + i k, at each wavelength.
/// @param cosTheta_i  in [0,1]
/// @param eta, k      in [0, 1e6], relative to the medium outside; both zero reflect everything
/// Source: the complex Fresnel equations with the root taken apart into its real and imaginary part
/// [Born and Wolf 1999, sec. 14.2].
SampledSpectrum FresnelConductor(float cosTheta_i, SampledSpectrum eta, SampledSpectrum k);

/// Reflectances of a smooth dielectric boundary for diffuse light, by its two sides.
struct DiffuseFresnel {
    float fromAbove, fromBelow;
};
/// @param eta  index below over index above, > 0  Source: the integral of Fresnel's factor in closed form
/// [Duntley 1942]; from the denser side total reflection adds to it.
DiffuseFresnel DiffuseReflectance(float eta);

inline Vec3 Reflect(Vec3 w, Vec3 n) { return 2 * Dot(w, n) * n - w; }

/// A refracted direction, and the index on its side over the index on the side that it came from.
struct Refraction {
    Vec3 w;
    float eta;
};
/// Direction into which `w` continues on the other side of the boundary with normal n; both point away from
/// it.
/// @param eta  index on the side away from n over index on the side of n, > 0
/// Empty under total internal reflection.
inline std::optional<Refraction> Refract(Vec3 w, Vec3 n, float eta) {
    float cosTheta = Dot(n, w);
    if (cosTheta < 0) {
        eta = 1 / eta;
        cosTheta = -cosTheta;
        n = -n;
    }
    const float cos2Theta_t = 1 - std::max(0.f, (1 - cosTheta) * (1 + cosTheta)) / (eta * eta);
    if (!(cos2Theta_t > 0)) return std::nullopt;
    const float over = 1 / eta;
    return Refraction{(cosTheta * over - std::sqrt(cos2Theta_t)) * n - over * w, eta};
}

}  // namespace lacquer
