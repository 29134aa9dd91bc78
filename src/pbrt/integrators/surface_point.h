// What integrators do at every hit: find the material, its frame, and its BxDF.
#pragma once

#include "pbrt/base/integrator.h"
#include "pbrt/integrators/footprint.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

/// A BxDF in the shading frame of a surface point: directions are in rendering space.
struct Bsdf {
    BxDF* bxdf = nullptr;
    Frame frame;
    Vec3 wo{0};                          ///< local
    const Material* material = nullptr;  ///< whose it is, as Material::Choose() has it

    Lobes Flags() const { return bxdf->Flags(); }
    BxDFValue Evaluate(Vec3 wi, const BxDFContext& context) const {
        return bxdf->Evaluate(wo, frame.ToLocal(wi), context);
    }
    float Pdf(Vec3 wi, const BxDFContext& context) const { return bxdf->Pdf(wo, frame.ToLocal(wi), context); }
    /// The sample's wi is in rendering space.
    std::optional<BxDFSample> Sample(const BxDFRandom& u, const BxDFContext& context) const {
        std::optional<BxDFSample> s = bxdf->Sample(wo, u, context);
        if (s) s->wi = frame.FromLocal(s->wi);
        return s;
    }
};

/// Chooses the material, fills the footprint, bumps the frame and builds the BxDF in `arena`. Empty where
/// nothing scatters: the interface material. `firstHit` is the camera ray if this is its first hit, else
/// null.
inline std::optional<Bsdf> MakeBsdf(SurfaceInteraction* si, const CameraRay* firstHit,
                                    const FootprintEstimator& footprint, SampledWavelengths& lambda,
                                    Arena& arena) {
    std::optional<Bsdf> bsdf;  // the only thing returned: made where the caller has it
    const Material* material = si->material;
    if (!material || material->IsInterface()) return bsdf;
    if (material->NeedsFootprint()) {
        if (firstHit)
            footprint.AtFirstHit(*firstHit, si);
        else
            footprint.Anywhere(si);
    }
    TextureContext context(*si);
    material = material->Choose(context, si->wo);
    if (material->HasBump()) {
        material->Bump(*si);
        context = TextureContext(*si);
    }
    BxDF* bxdf = material->MakeBxDF(context, lambda, arena);
    if (!bxdf) return bsdf;
    bsdf.emplace();
    bsdf->bxdf = bxdf;
    bsdf->frame = Frame::FromZX(si->shading.n, si->shading.dpdu);
    bsdf->wo = bsdf->frame.ToLocal(si->wo);
    bsdf->material = material;
    return bsdf;
}

/// Follows a camera ray to the first surface that scatters, through interfaces, and records it where `state`
/// asks for that. Empty if there is none.
inline std::optional<Bsdf> FirstBsdf(const Scene& scene, const CameraRay& cameraRay,
                                     const FootprintEstimator& footprint, SampledWavelengths& lambda,
                                     ThreadState& state, SurfaceInteraction* si) {
    std::optional<Bsdf> bsdf;
    Ray ray = cameraRay.ray;
    while (++state.raysTraced, scene.Intersect(ray, Infinity, si)) {
        bsdf = MakeBsdf(si, &cameraRay, footprint, lambda, state.arena);
        if (bsdf) break;
        ray = SpawnRay(*si, ray.d);
    }
    if (bsdf && state.firstHit) state.firstHit->Record(*si, *bsdf->bxdf, bsdf->wo);
    return bsdf;
}

}  // namespace lacquer
