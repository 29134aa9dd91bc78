// What integrators do along every path: trace its rays, and find what scatters light where they end.
#pragma once

#include <limits>
#include <optional>
#include <utility>

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

/// What all paths of an integrator have in common.
struct PathSurroundings {
    explicit PathSurroundings(const IntegratorArgs& args)
        : scene(args.scene), footprint(args.scene.Camera(), args.scene.Resolution(), args.footprintScale) {}

    const Scene& scene;
    FootprintEstimator footprint;
};

/// What becomes of a path at a surface.
enum class AtSurface {
    Passes,    ///< nothing scatters there (the interface material): the ray goes on behind it
    Scatters,  ///< the path has one vertex more
    /// Something scatters, but the path has as many vertices as it may have; or the camera looks at a
    /// holdout.
    Ends
};

/// One path from the camera or from a light, as long as an integrator follows it. It is the only way to the
/// BSDF of a surface, so that no integrator can forget what comes with one: the texture footprint, the record
/// of the camera's first hit for auxiliary outputs, the count of vertices, and the depth at which paths end.
/// Rays count themselves (Scene::Intersect, Scene::Visible).
class TracedPath {
  public:
    static constexpr int kUnlimited = std::numeric_limits<int>::max();

    /// A path along a camera ray, which outlives it, with at most `maxDepth` vertices that scatter.
    static TracedPath FromCamera(const PathSurroundings& surroundings, const CameraRay& cameraRay,
                                 int maxDepth, ThreadState& state) {
        return {surroundings, &cameraRay, maxDepth, state};
    }
    /// A path that begins elsewhere, as long as its integrator likes.
    static TracedPath FromLight(const PathSurroundings& surroundings, ThreadState& state) {
        return {surroundings, nullptr, kUnlimited, state};
    }

    /// The nearest hit of a ray of this path, as Scene::Intersect() has it; the camera sees no light of
    /// holdouts.
    bool Intersect(const Ray& ray, SurfaceInteraction* si, float tMax = Infinity) {
        const bool hit = surroundings_->scene.Intersect(ray, tMax, si, state_->rays);
        if (hit && IsHeldOut(*si)) si->areaLight = nullptr;
        return hit;
    }
    /// The path arrives at a surface: chooses its material, fills the footprint, bumps the frame and makes
    /// the BSDF, whose BxDF lives in the arena of the thread. `bsdf` is set where the path scatters.
    [[nodiscard]] AtSurface Scatter(SurfaceInteraction* si, SampledWavelengths& lambda, Bsdf* bsdf) {
        if (IsHeldOut(*si)) return AtSurface::Ends;
        if (!MakeBsdf(si, lambda, bsdf)) return AtSurface::Passes;
        if (std::exchange(cameraRay_, nullptr) && state_->firstHit)
            state_->firstHit->Record(*si, *bsdf->bxdf, bsdf->wo);
        return AddVertex() ? AtSurface::Scatters : AtSurface::Ends;
    }
    /// The path scatters in a medium; no surface is the camera's first hit any more. False: it ends instead.
    [[nodiscard]] bool ScatterInMedium() {
        Cover(1);
        cameraRay_ = nullptr;
        return AddVertex();
    }
    /// A medium takes this part of the light along the ray: by absorption, or all of it where the ray is
    /// absorbed.
    void Cover(float part) {
        if (cameraRay_ && state_->firstHit) state_->firstHit->Cover(part);
    }
    /// Follows a ray to the first surface that scatters, through interfaces. False if there is none, or a
    /// holdout.
    bool FollowToSurface(Ray ray, SampledWavelengths& lambda, SurfaceInteraction* si) {
        Bsdf bsdf;
        while (Intersect(ray, si)) {
            const AtSurface at = Scatter(si, lambda, &bsdf);
            if (at != AtSurface::Passes) return at == AtSurface::Scatters;
            ray = SpawnRay(*si, ray.d);
        }
        return false;
    }
    /// Number of vertices that scattered so far.
    int Depth() const { return depth_; }

  private:
    TracedPath(const PathSurroundings& surroundings, const CameraRay* cameraRay, int maxDepth,
               ThreadState& state)
        : surroundings_(&surroundings), cameraRay_(cameraRay), state_(&state), maxDepth_(maxDepth) {}

    /// The camera looks at a holdout, not by way of another surface.
    bool IsHeldOut(const SurfaceInteraction& si) const {
        return cameraRay_ && si.material && si.material->IsHoldout() && !si.material->IsInvisible();
    }

    bool AddVertex() {
        if (depth_ == maxDepth_) return false;
        ++depth_;
        ++state_->pathLengthSum;
        state_->dimensions.StartVertex(depth_);
        return true;
    }

    bool MakeBsdf(SurfaceInteraction* si, SampledWavelengths& lambda, Bsdf* bsdf) const {
        const Material* material = si->material;
        if (!material || material->IsInvisible()) return false;
        if (material->NeedsFootprint()) {
            if (cameraRay_)
                surroundings_->footprint.AtFirstHit(*cameraRay_, si);
            else
                surroundings_->footprint.ApproximateFootprint(si);
        }
        TextureContext context(*si);
        material = material->Choose(context, si->wo);
        if (material->HasBump()) {
            material->Bump(*si);
            context = TextureContext(*si);
        }
        BxDF* bxdf = material->MakeBxDF(context, lambda, state_->arena);
        if (!bxdf) return false;
        bsdf->bxdf = bxdf;
        bsdf->frame = Frame::FromZX(si->shading.n, si->shading.dpdu);
        bsdf->wo = bsdf->frame.ToLocal(si->wo);
        bsdf->material = material;
        return true;
    }

    const PathSurroundings* surroundings_;
    const CameraRay* cameraRay_;  ///< null: the first hit is behind, or the path is not the camera's
    ThreadState* state_;
    int maxDepth_;
    int depth_ = 0;
};

}  // namespace lacquer
