#include "pbrt/scene/light_media.h"

#include <unordered_map>

#include "pbrt/scene/scene.h"

namespace lacquer {
namespace {

/// Along no axis, where walls would be met at their edges.
const Vec3 kAnyDirection = Normalize(Vec3(0.36f, 0.47f, 0.81f));
/// More surfaces than this between a point and a boundary of its medium are not looked through.
constexpr int kMaxSurfaces = 1000;

bool IsBoundary(const SurfaceInteraction& si) {
    return si.mediumInterface && si.mediumInterface->inside != si.mediumInterface->outside;
}

/// What a point is in: the near side of the first boundary along some ray.
/// @param outermost  of points around which there is none
const Medium* MediumAround(const Scene& scene, Ray ray, const Medium* outermost) {
    RayCounts counts;
    SurfaceInteraction si;
    for (int i = 0; i < kMaxSurfaces && scene.Intersect(ray, Infinity, &si, counts); ++i) {
        if (IsBoundary(si)) return si.MediumToward(-ray.d, nullptr);
        ray = SpawnRay(si, ray.d);
    }
    return outermost;
}

/// What a ray from the camera is in at last.
const Medium* OutermostMedium(const Scene& scene) {
    const Medium* medium = scene.CameraMedium();
    const std::optional<CameraRay> center =
        scene.Camera().GenerateRay({.pFilm = Vec2(scene.Resolution()) * 0.5f});
    if (!center) return medium;
    Ray ray{center->ray.o, kAnyDirection, center->ray.time};
    RayCounts counts;
    SurfaceInteraction si;
    for (int i = 0; i < kMaxSurfaces && scene.Intersect(ray, Infinity, &si, counts); ++i) {
        medium = si.MediumToward(ray.d, medium);
        ray = SpawnRay(si, ray.d);
    }
    return medium;
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

std::vector<LightMedia> FindLightMedia(const Scene& scene) {
    const auto boundaries = EmittingBoundaries(scene.Parts());
    const Medium* outermost = OutermostMedium(scene);
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.5f);
    std::vector<LightMedia> result;
    result.reserve(scene.Lights().size());
    for (const Light* light : scene.Lights()) {
        const auto boundary = boundaries.find(light);
        LightMedia media{boundary == boundaries.end() ? nullptr : boundary->second, outermost};
        const bool isInside =
            light->GetKind() == Light::Kind::Area || light->GetKind() == Light::Kind::DeltaPosition;
        if (isInside && !media.interface) {
            // Some point of it, and a direction into which it shines.
            if (const auto emitted = light->SampleLe(Point2(0.5f), Point2(0.5f), lambda)) {
                SurfaceInteraction si;
                si.p = emitted->p;
                si.pError = emitted->pError;
                si.n = emitted->n;
                media.around = MediumAround(scene, SpawnRay(si, emitted->w), outermost);
            }
        }
        result.push_back(media);
    }
    return result;
}

}  // namespace lacquer
