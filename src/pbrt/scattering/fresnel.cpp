#include "pbrt/scattering/fresnel.h"

#include <cmath>

namespace lacquer {

SampledSpectrum FresnelConductor(float cosTheta_i, SampledSpectrum eta, SampledSpectrum k) {
    const float c = std::clamp(cosTheta_i, 0.f, 1.f), c2 = c * c, s2 = (1 - c) * (1 + c);
    const SampledSpectrum eta2 = eta * eta, k2 = k * k;

    // a + i b = sqrt((eta + i k)^2 - sin^2 theta), the normal component of the refracted wave vector.
    const SampledSpectrum d = eta2 - k2 - SampledSpectrum(s2);
    const SampledSpectrum a2b2 = Sqrt(d * d + 4 * (eta2 * k2));
    const SampledSpectrum a = SafeSqrt(0.5f * (a2b2 + d));

    // Perpendicular polarisation, then parallel as a multiple of it.
    const SampledSpectrum t1 = a2b2 + SampledSpectrum(c2), t2 = a * (2 * c);
    const SampledSpectrum t3 = a2b2 * c2 + SampledSpectrum(s2 * s2), t4 = t2 * s2;
    const SampledSpectrum perpendicular = (t1 - t2) / (t1 + t2);
    // At normal incidence both are the same, and the quotient may be 0/0.
    const SampledSpectrum denominator = t3 + t4;
    const SampledSpectrum ratio =
        (denominator.Raw() > 0.f) ? ((t3 - t4) / denominator).Raw() : SampledSpectrum(1).Raw();
    return Clamp(0.5f * perpendicular * (SampledSpectrum(1) + ratio), 0, 1);
}

DiffuseFresnel DiffuseReflectance(float eta) {
    const double n = double(std::max(eta, 1 / eta)), n2 = n * n, n4 = n2 * n2;
    if (!(n > 1 + 1e-4)) return {0, 0};
    const double logarithms = n2 * Sqr(n2 - 1) / (Sqr(n2 + 1) * (n2 + 1)) * std::log((n - 1) / (n + 1)) +
                              8 * n4 * (n4 + 1) / ((n2 + 1) * Sqr(n4 - 1)) * std::log(n);
    const double outside = 0.5 + (n - 1) * (3 * n + 1) / (6 * Sqr(n + 1)) -
                           2 * n * n2 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) + logarithms;
    // What passes is the same both ways, but for the solid angle.
    const auto thin = float(std::min(outside, 1.0)), dense = float(1 - (1 - std::min(outside, 1.0)) / n2);
    return eta > 1 ? DiffuseFresnel{thin, dense} : DiffuseFresnel{dense, thin};
}

}  // namespace lacquer
