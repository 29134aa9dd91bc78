#include "pbrt/integrators/footprint.h"

namespace lacquer {

FootprintEstimator::FootprintEstimator(const Camera& camera, Int2 resolution, float scale)
    : camera_(&camera), scale_(scale) {
    // The narrowest pixel along the diagonal stands for the camera.
    constexpr int kProbes = 64;
    minPosition_ = minDirection_ = Infinity;
    for (int i = 0; i < kProbes; ++i) {
        const float t = (float(i) + 0.5f) / kProbes;
        const auto ray =
            camera.GenerateRay({{t * float(resolution.x), t * float(resolution.y)}, {0.5f, 0.5f}, 0.5f});
        if (!ray) continue;
        minPosition_ =
            std::min({minPosition_, Length(ray->rxOrigin - ray->ray.o), Length(ray->ryOrigin - ray->ray.o)});
        minDirection_ = std::min(
            {minDirection_, Length(ray->rxDirection - ray->ray.d), Length(ray->ryDirection - ray->ray.d)});
    }
    if (!std::isfinite(minPosition_)) minPosition_ = minDirection_ = 0;
}

void FootprintEstimator::Set(Vec3 dpdx, Vec3 dpdy, SurfaceInteraction* si) const {
    si->dpdx = IsFinite(dpdx) ? dpdx : Vec3(0);
    si->dpdy = IsFinite(dpdy) ? dpdy : Vec3(0);
    si->ComputeUvFootprint();
}

void FootprintEstimator::AtFirstHit(const CameraRay& ray, SurfaceInteraction* si) const {
    const auto onPlane = [&](Point3 o, Vec3 d) {
        // The neighbour at the sample's share of a pixel.
        const Point3 origin = ray.ray.o + scale_ * (o - ray.ray.o);
        const Vec3 direction = ray.ray.d + scale_ * (d - ray.ray.d);
        const float t = Dot(si->n, si->p - origin) / Dot(si->n, direction);
        return origin + t * direction - si->p;
    };
    Set(onPlane(ray.rxOrigin, ray.rxDirection), onPlane(ray.ryOrigin, ray.ryDirection), si);
}

void FootprintEstimator::ApproximateFootprint(SurfaceInteraction* si) const {
    const Point3 eye = camera_->RenderFromCamera().Start().Point(Point3(0));
    const Vec3 toPoint = si->p - eye;
    const float distance = Length(toPoint);
    if (!(distance > 0)) return Set(Vec3(0), Vec3(0), si);
    const Frame frame = Frame::FromZ(toPoint / distance);
    const auto onPlane = [&](Vec3 across) {
        const Point3 origin = eye + scale_ * minPosition_ * across;
        const Vec3 direction = frame.z + scale_ * minDirection_ * across;
        const float t = Dot(si->n, si->p - origin) / Dot(si->n, direction);
        return origin + t * direction - si->p;
    };
    Set(onPlane(frame.x), onPlane(frame.y), si);
}

}  // namespace lacquer
