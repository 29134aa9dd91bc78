// Flights of paths through media: until they scatter, until they are absorbed, or to the other side.
#pragma once

#include "pbrt/base/interaction.h"
#include "pbrt/base/sampler.h"
#include "pbrt/integrators/medium_tracking.h"
#include "pbrt/integrators/spectral_mis.h"

namespace lacquer {

/// A point of a medium on a ray, as what has no surface.
inline SurfaceInteraction InMedium(Point3 p, const Ray& ray) {
    SurfaceInteraction si;
    si.p = p;
    si.n = si.shading.n = Normal3(0);
    si.wo = -ray.d;
    si.time = ray.time;
    return si;
}

/// Where a flight ends.
struct MediumFlight {
    enum class End { Crossed, Scattered, Absorbed };

    End end = End::Crossed;
    Point3 p{0};        ///< where Scattered
    float covered = 0;  ///< the part of the light along the ray that absorption is known to take
};

/// Follows a ray (unit direction) through its medium up to tMax: by delta tracking of the first wavelength,
/// with certainty where the medium is homogeneous and does not scatter.
/// @param beta  throughput over density at the first wavelength
/// @param emit  (light, pdfs): light that the medium sends back along the path, undivided, and what its
///              MeanPdf() is to be divided by
template <class Emit>
MediumFlight FlyThrough(const Medium& medium, const Ray& ray, float tMax, const SampledWavelengths& lambda,
                        SampledSpectrum* beta, SpectralPdfs* pdfs, Sampler& sampler, Rng& rng,
                        const Emit& emit) {
    MediumFlight flight;
    if (medium.IsHomogeneous()) {
        const MediumProperties everywhere = medium.Along(ray, lambda);
        if (!everywhere.sigma_s) {
            const SampledSpectrum T = Exp(-tMax * everywhere.sigma_a);
            flight.covered = 1 - T.Average();
            if (everywhere.Le) emit(*beta * (1 - T) * everywhere.Le, pdfs->scattering);
            *beta *= T;
            if (!*beta) flight.end = MediumFlight::End::Absorbed;
            return flight;
        }
    }
    // A tentative collision: emission there; then the path is absorbed, scattered, or goes on (a null
    // collision), by the shares of the three at the first wavelength.
    const auto collide = [&](const MajorantCollision& at) {
        const MediumProperties& m = at.medium;
        const SampledSpectrum scaled = at.Tmaj / (at.Tmaj[0] * at.sigmaMaj[0]);
        if (m.Le) emit(*beta * scaled * m.sigma_a * m.Le, pdfs->scattering * scaled * at.sigmaMaj);
        const float u = rng.Uniform() * at.sigmaMaj[0];
        if (u < m.sigma_a[0]) {
            flight.covered = 1;
            flight.end = MediumFlight::End::Absorbed;
            return false;
        }
        if (u >= m.sigma_a[0] + m.sigma_s[0]) {
            const SampledSpectrum sigma_n = Max(at.sigmaMaj - m.SigmaT(), SampledSpectrum(0));
            if (sigma_n[0] == 0) {
                flight.end = MediumFlight::End::Absorbed;
                return false;
            }
            const SampledSpectrum null = scaled * sigma_n * (at.sigmaMaj[0] / sigma_n[0]);
            *beta *= null;
            pdfs->scattering *= null;
            pdfs->light *= scaled * at.sigmaMaj * (at.sigmaMaj[0] / sigma_n[0]);
            return true;
        }
        const SampledSpectrum real = scaled * m.sigma_s * (at.sigmaMaj[0] / m.sigma_s[0]);
        *beta *= real;
        pdfs->scattering *= real;
        flight.p = at.p;
        flight.end = MediumFlight::End::Scattered;
        return false;
    };
    const SampledSpectrum Tmaj = TrackCollisions(medium, ray, tMax, sampler.Get1D(), rng, lambda, collide);
    if (flight.end != MediumFlight::End::Crossed) return flight;
    const SampledSpectrum scaled = Tmaj / Tmaj[0];
    *beta *= scaled;
    pdfs->scattering *= scaled;
    // A light sample crosses a homogeneous medium with certainty, and others as this path does
    // (TraceShadowRay).
    pdfs->light *= medium.IsHomogeneous() ? SampledSpectrum(1 / Tmaj[0]) : scaled;
    return flight;
}

/// A direction that a phase function has drawn.
struct DrawnDirection {
    Vec3 wi;
    float pdf;  ///< [1/sr], at the first wavelength
};
/// Draws one, as a path counts it: chromatic ones are drawn for the first wavelength, as flights are. Empty
/// by rounding, at the end of a lobe.
inline std::optional<DrawnDirection> SamplePhase(const PhaseFunction& phase, Vec3 wo, SampledSpectrum* beta,
                                                 SpectralPdfs* pdfs, Rng& rng) {
    const PhaseSample sample = phase.Sample(wo, rng);
    if (!phase.IsChromatic()) {
        *beta *= sample.weight;
        return DrawnDirection{sample.wi, sample.pdf};
    }
    if (!(sample.pdf > 0)) return {};
    const SpectralPhaseValue value = phase.EvaluateSpectral(wo, sample.wi);
    *beta *= value.p / sample.pdf;
    pdfs->scattering *= value.pdf / sample.pdf;
    return DrawnDirection{sample.wi, sample.pdf};
}

}  // namespace lacquer
