#include "pbrt/scene/light_media.h"

#include <unordered_map>

#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scene/scene.h"

namespace lacquer {
namespace {

/// Directions to look into. The first one that no scattering surface hides decides: what lies behind such
/// surfaces need not agree with their media.
constexpr int kDirections = 16;
/// More surfaces than this are not looked through.
constexpr int kMaxSurfaces = 1000;

/// Evenly spread, along no axis, where walls would be met at their edges.
Vec3 Direction(int i) {
    const float golden = 0.618034f;
    const Point2 u((float(i) + 0.37f) / kDirections, std::fmod(float(i) * golden + 0.13f, 1.f));
    return SampleUniformSphere(u);
}

bool IsBoundary(const SurfaceInteraction& si) {
    return si.mediumInterface && si.mediumInterface->inside != si.mediumInterface->outside;
}

/// What a look along a ray says of a medium.
struct Sight {
    const Medium* medium = nullptr;
    bool isClear = true;  ///< no surface that scatters is in the way
};

/// Follows a ray through all surfaces. @param meet  (hit, direction): false to stop there
/// @return  whether no surface that scatters was on the way to where it stopped
template <class Meet>
bool SeesThrough(const Scene& scene, Ray ray, const Meet& meet) {
    bool isClear = true;
    RayCounts counts;
    SurfaceInteraction si;
    for (int i = 0; i < kMaxSurfaces && scene.Intersect(ray, Infinity, &si, counts); ++i) {
        if (!meet(si, ray.d)) break;
        isClear &= !si.material || si.material->IsInvisible();
        ray = SpawnRay(si, ray.d);
    }
    return isClear;
}

/// What a ray is in at its end, which begins in `medium`.
Sight LookOut(const Scene& scene, const Ray& ray, const Medium* medium) {
    Sight sight{medium};
    sight.isClear = SeesThrough(scene, ray, [&](const SurfaceInteraction& si, Vec3 w) {
        sight.medium = si.MediumToward(w, sight.medium);
        return true;
    });
    return sight;
}

/// What the origin of a ray is in: the near side of the first boundary.
/// @param outermost  where there is none
Sight LookAround(const Scene& scene, const Ray& ray, const Medium* outermost) {
    Sight sight{outermost};
    sight.isClear = SeesThrough(scene, ray, [&](const SurfaceInteraction& si, Vec3 w) {
        if (!IsBoundary(si)) return true;
        sight.medium = si.MediumToward(-w, nullptr);
        return false;
    });
    return sight;
}

/// The first clear sight, or else the first one. @param look  (direction): a Sight
template <class Look>
const Medium* FirstClear(const Look& look) {
    const Sight first = look(Direction(0));
    if (first.isClear) return first.medium;
    for (int i = 1; i < kDirections; ++i)
        if (const Sight sight = look(Direction(i)); sight.isClear) return sight.medium;
    return first.medium;
}

/// Some point of a light, and n of what it is on.
SurfaceInteraction PointOf(const Light& light) {
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.5f);
    SurfaceInteraction si;
    si.n = Normal3(0);
    for (const float u : {0.37f, 0.71f, 0.12f})
        if (const auto emitted = light.SampleLe(Point2(u, 0.43f), Point2(0.3f, u), lambda)) {
            si.p = emitted->p;
            si.pError = emitted->pError;
            si.n = emitted->n;
            return si;
        }
    // It may be dark there, or at these wavelengths.
    if (const std::optional<LightBounds> bounds = light.Bounds())
        si.p = 0.5f * (bounds->bounds.min + bounds->bounds.max);
    return si;
}

/// By their lights, the media of emitting surfaces that are boundaries.
std::unordered_map<const Light*, const MediumInterface*> EmittingBoundaries(const SceneParts& parts) {
    std::unordered_map<const Light*, const MediumInterface*> boundaries;
    for (const std::vector<Primitive>& group : parts.groups)
        for (const Primitive& primitive : group) {
            if (primitive.firstLight < 0 || primitive.media.inside == primitive.media.outside) continue;
            for (int i = 0; i < primitive.shape->NumPrimitives(); ++i)
                boundaries[parts.areaLights[size_t(primitive.firstLight + i)].get()] = &primitive.media;
        }
    return boundaries;
}

}  // namespace

const Medium* OutermostMedium(const Scene& scene) {
    // Where the lens lets a ray through is as good as any place of the camera.
    const Vec2 resolution(scene.Resolution());
    std::optional<CameraRay> camera;
    for (const float part : {0.5f, 0.4f, 0.3f, 0.2f, 0.1f, 0.f})
        if (!camera) camera = scene.Camera().GenerateRay({.pFilm = part * resolution});
    if (!camera) return scene.CameraMedium();
    return FirstClear([&](Vec3 w) {
        return LookOut(scene, {camera->ray.o, w, camera->ray.time}, scene.CameraMedium());
    });
}

std::vector<LightMedia> FindLightMedia(const Scene& scene) {
    const auto boundaries = EmittingBoundaries(scene.Parts());
    const Medium* outermost = OutermostMedium(scene);
    const std::vector<const Light*>& lights = scene.Lights();
    std::vector<LightMedia> result(lights.size());
    ParallelFor(int64_t(lights.size()), [&](int64_t i) {
        const Light& light = *lights[size_t(i)];
        LightMedia& media = result[size_t(i)];
        media.around = outermost;
        if (light.IsInfinite() || light.GetKind() == Light::Kind::DeltaDirection) return;
        // What rays do not hit, as lamps with alpha 0, bounds nothing.
        if (const auto found = boundaries.find(&light); found != boundaries.end() && !light.IsDelta()) {
            media.interface = found->second;
            return;
        }
        const SurfaceInteraction si = PointOf(light);
        media.around = FirstClear([&](Vec3 w) { return LookAround(scene, SpawnRay(si, w), outermost); });
    });
    return result;
}

}  // namespace lacquer
