#include "pbrt/integrators/shadow_ray.h"

#include "pbrt/integrators/medium_tracking.h"

namespace lacquer {

namespace {

void CrossHomogeneous(const Medium& medium, const Ray& ray, float length, const SampledWavelengths& lambda,
                      ShadowRay* shadow) {
    const MediumProperties properties = medium.Along(ray, lambda);
    const SampledSpectrum T = Exp(-length * properties.SigmaT());
    shadow->T *= T;
    // The light sample is certain to get through; a scattered ray draws a distance, unless nothing scatters.
    if (properties.sigma_s) {
        shadow->pdfs.scattering *= T;
        shadow->knownT *= T.Average();
    }
}

void CrossByRatioTracking(const Medium& medium, const Ray& ray, float length,
                          const SampledWavelengths& lambda, Rng& rng, ShadowRay* shadow) {
    constexpr float kSmall = 0.05f, kSurvival = 0.25f;
    const auto nullCollision = [&](const MajorantCollision& collision) {
        const SampledSpectrum sigma_n =
            Max(collision.sigmaMaj - collision.medium.SigmaT(), SampledSpectrum(0));
        const SampledSpectrum scaled = collision.Tmaj / (collision.Tmaj[0] * collision.sigmaMaj[0]);
        shadow->T *= scaled * sigma_n;
        shadow->pdfs.light *= scaled * collision.sigmaMaj;
        shadow->pdfs.scattering *= scaled * sigma_n;
        if (shadow->T.MaxComponent() < kSmall * MeanPdf(shadow->pdfs.light, lambda)) {
            if (rng.Uniform() >= kSurvival) shadow->T = SampledSpectrum(0);
            shadow->T /= kSurvival;
        }
        return bool(shadow->T);
    };
    const SampledSpectrum Tmaj =
        TrackCollisions(medium, ray, length, rng.Uniform(), rng, lambda, nullCollision);
    const SampledSpectrum scaled = Tmaj / Tmaj[0];
    shadow->T *= scaled;
    shadow->pdfs.light *= scaled;
    shadow->pdfs.scattering *= scaled;
}

}  // namespace

ShadowRay TraceShadowRay(const Scene& scene, const LightReference& from, const LightSample& to, float time,
                         const Medium* medium, const SampledWavelengths& lambda, ThreadState& state) {
    ShadowRay shadow;
    const auto cross = [&](const Ray& ray, float length, const SurfaceInteraction* hit) {
        if (medium && medium->IsHomogeneous())
            CrossHomogeneous(*medium, ray, length, lambda, &shadow);
        else if (medium)
            CrossByRatioTracking(*medium, ray, length, lambda, state.rng, &shadow);
        if (hit) medium = hit->MediumToward(ray.d, medium);
        return bool(shadow.T);
    };
    if (!scene.FollowToLight(RayToLight(from, to, time), state.rays, cross)) shadow.T = SampledSpectrum(0);
    return shadow;
}

ShadowRay TraceShadowRay(const Scene& scene, const SurfaceInteraction& from, const LightSample& to, Vec3 w,
                         const Medium* around, const SampledWavelengths& lambda, ThreadState& state) {
    if (scene.HasMedia())
        return TraceShadowRay(scene, LightReference(from), to, from.time, from.MediumToward(w, around),
                              lambda, state);
    ShadowRay shadow;
    if (!scene.Visible(from, to, true, state.rays)) shadow.T = SampledSpectrum(0);
    return shadow;
}

}  // namespace lacquer
