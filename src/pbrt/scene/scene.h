// The scene as it is rendered: built once, constant afterwards, shared by all threads.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/accel/accelerator.h"
#include "pbrt/base/camera.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/light.h"
#include "pbrt/base/material.h"
#include "pbrt/base/medium.h"
#include "pbrt/base/scene_names.h"

namespace lacquer {

/// A shape with everything that the scene file said about it.
struct Primitive {
    std::unique_ptr<Shape> shape;
    const Material* material = nullptr;
    const FloatTexture* alpha = nullptr;  ///< null: no holes
    MediumInterface media;
    int object = -1;  ///< index of the object; those of instances stand with the instances
    int firstLight =
        -1;  ///< index in Scene::areaLights of the light of the shape's first primitive; -1: no emitter
    bool wantsNormalDerivatives = true;  ///< of hits; the scene knows whether its material may read them
};

/// What the scene is made of, with its owners. Filled by the builder.
struct SceneParts {
    std::unique_ptr<Camera> camera;
    Int2 resolution{0};
    std::vector<std::vector<Primitive>> groups;  ///< [0] is the world, the others the objects of instances
    std::vector<AccelInstance> instances;
    std::vector<int> instanceObjects;                ///< indices of the objects that the instances are
    SceneNames names;                                ///< empty unless asked for
    std::vector<std::string> lightGroups{""};        ///< names; [0]: of lights and media that have none
    std::vector<std::unique_ptr<Light>> lights;      ///< point-like and infinite
    std::vector<std::unique_ptr<Light>> areaLights;  ///< one for each emitting primitive
    std::vector<std::unique_ptr<Material>> materials;
    std::vector<std::unique_ptr<Medium>> media;
    const Medium* cameraMedium = nullptr;      ///< around the camera; null: vacuum
    std::shared_ptr<TextureLibrary> textures;  ///< keeps the textures alive
};

/// Shadow rays end this part of their length before the light.
inline constexpr float kShadowRayEnd = 1 - 1e-4f;
/// The ray from a point to a light sample, whose t is 1 there; its origin is off the surface.
inline Ray RayToLight(const LightReference& from, const LightSample& to, float time) {
    const Point3 origin = OffsetRayOrigin(from.p, from.pError, from.n, to.p - from.p);
    const Point3 target = to.n == Normal3(0) ? to.p : OffsetRayOrigin(to.p, to.pError, to.n, origin - to.p);
    return {origin, target - origin, time};
}

/// Rays, lights and bounds. All functions are const and thread-safe.
class Scene {
  public:
    explicit Scene(SceneParts parts);

    // Whatever traces rays adds them to `counts`, so that nobody can trace one that does not count.

    /// Nearest hit with 0 < t < tMax; fills everything of `si` but the footprint. wo is -d, which must be
    /// unit.
    bool Intersect(const Ray& ray, float tMax, SurfaceInteraction* si, RayCounts& counts) const {
        ++counts.nearest;
        return NearestHit(ray, tMax, si);
    }
    /// True if there is any hit with 0 < t < tMax.
    bool Occluded(const Ray& ray, float tMax, RayCounts& counts) const {
        ++counts.shadow;
        return accelerator_->Occluded(ray, tMax);
    }
    /// True if nothing stands between a surface point and a light sample; with `throughInterfaces`, surfaces
    /// of the interface material do not count.
    bool Visible(const SurfaceInteraction& from, const LightSample& to, bool throughInterfaces,
                 RayCounts& counts) const;

    /// Follows a ray of RayToLight() through surfaces of the interface material.
    /// @param cross  (ray, length, hit) of each piece: its unit ray and the interaction at its end, null
    ///               where that is the light; false stops
    /// @return       false if something else stands in the way, or if `cross` stopped
    template <class Cross>
    bool FollowToLight(Ray ray, RayCounts& counts, const Cross& cross) const {
        float left = Length(ray.d);
        if (!(left > 0)) return true;
        ray.d /= left;
        left *= kShadowRayEnd;
        SurfaceInteraction si;
        for (;;) {
            ++counts.shadow;
            const bool hit = NearestHit(ray, left, &si);
            if (hit && !(si.material && si.material->IsInvisible())) return false;
            if (!cross(ray, hit ? Dot(si.p - ray.o, ray.d) : left, hit ? &si : nullptr)) return false;
            if (!hit) return true;
            const Point3 next = OffsetRayOrigin(si.p, si.pError, si.n, ray.d);
            left -= Length(next - ray.o);
            if (left <= 0) return true;
            ray.o = next;
        }
    }

    const lacquer::Camera& Camera() const { return *parts_.camera; }
    const SceneParts& Parts() const { return parts_; }
    Int2 Resolution() const { return parts_.resolution; }
    /// Every light; the area lights first.
    const std::vector<const Light*>& Lights() const { return lights_; }
    /// Those that scattered rays cannot find as well as light samples can: all but uniform infinite ones.
    const std::vector<const Light*>& SampledLights() const { return sampledLights_; }
    const std::vector<const Light*>& InfiniteLights() const { return infiniteLights_; }
    Bounds3 Bounds() const { return accelerator_->Bounds(); }
    const lacquer::Accelerator& Accelerator() const { return *accelerator_; }
    /// Empty unless BuildOptions::keepNames was set.
    const SceneNames& Names() const { return parts_.names; }
    bool HasInterfaces() const { return hasInterfaces_; }
    /// True if any surface is of a material that scatters.
    bool HasScatteringSurfaces() const { return hasScatteringSurfaces_; }
    /// True if light scatters below some surface (Material::HasSubsurface).
    bool HasSubsurface() const { return hasSubsurface_; }
    /// True if the camera or an instance may move while the shutter is open.
    bool IsMoving() const { return isMoving_; }
    bool HasMedia() const { return !parts_.media.empty(); }
    /// False if nothing can send out light: no light source, no medium that glows.
    bool HasEmission() const {
        return !lights_.empty() || std::any_of(parts_.media.begin(), parts_.media.end(),
                                               [](const auto& medium) { return medium->IsEmissive(); });
    }
    /// Around the camera; null: vacuum.
    const Medium* CameraMedium() const { return parts_.cameraMedium; }
    /// True if a part of an image texture could not be read, so that pixels since then are wrong. Cheap.
    bool TexturesFailed() const;
    /// Errors: FileError if TexturesFailed().
    void CheckTextures() const;
    int64_t NumPrimitives() const;
    /// Bytes of geometry, without the acceleration structure.
    size_t GeometryBytes() const;

  private:
    bool NearestHit(const Ray& ray, float tMax, SurfaceInteraction* si) const;

    SceneParts parts_;
    std::unique_ptr<lacquer::Accelerator> accelerator_;
    std::vector<const Light*> lights_, sampledLights_, infiniteLights_;
    bool hasInterfaces_ = false, hasScatteringSurfaces_ = false, hasSubsurface_ = false, isMoving_ = false;
};

/// A ray that leaves a surface point, its origin off the surface.
inline Ray SpawnRay(const SurfaceInteraction& si, Vec3 direction) {
    return {OffsetRayOrigin(si.p, si.pError, si.n, direction), direction, si.time};
}

}  // namespace lacquer
