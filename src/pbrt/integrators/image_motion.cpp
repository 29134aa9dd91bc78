#include "pbrt/integrators/image_motion.h"

namespace lacquer {

ImageMotion::ImageMotion(const Scene& scene) : scene_(scene) {
    const Camera& camera = scene.Camera();
    const auto atBothTimes = [&](const AnimatedTransform& moving) {
        return Pair{moving.At(camera.ShutterOpen()), moving.At(camera.ShutterClose())};
    };
    renderFromCamera_ = atBothTimes(camera.RenderFromCamera());
    for (const AccelInstance& instance : scene.Parts().instances)
        renderFromObject_.push_back(atBothTimes(instance.renderFromObject));
}

std::optional<Vec2> ImageMotion::Between(const Point3& first, const Point3& last, bool isDirection) const {
    std::array<std::optional<Point2>, 2> raster;
    for (size_t i = 0; i < 2; ++i) {
        const Transform& t = renderFromCamera_[i];
        const Vec3 p = i == 0 ? first : last;
        raster[i] =
            scene_.Camera().RasterOf(isDirection ? t.InverseVector(p) : t.InversePoint(p), isDirection);
    }
    if (!raster[0] || !raster[1]) return std::nullopt;
    // Rows are counted downward.
    return Vec2(raster[1]->x - raster[0]->x, raster[0]->y - raster[1]->y);
}

std::optional<Vec2> ImageMotion::Of(const FirstHit& hit, const Ray& ray) const {
    const bool cameraMoves = scene_.Camera().RenderFromCamera().IsAnimated();
    if (!hit.hit) {
        if (hit.coverage >= 1) return std::nullopt;
        return cameraMoves ? Between(ray.d, ray.d, true) : Vec2(0);
    }
    const AnimatedTransform* moving =
        hit.instance < 0 ? nullptr : &scene_.Parts().instances[size_t(hit.instance)].renderFromObject;
    if (!moving || !moving->IsAnimated()) return cameraMoves ? Between(hit.p, hit.p, false) : Vec2(0);
    const Pair& renderFromObject = renderFromObject_[size_t(hit.instance)];
    const Point3 p = moving->At(hit.time).InversePoint(hit.p);
    return Between(renderFromObject[0].Point(p), renderFromObject[1].Point(p), false);
}

}  // namespace lacquer
