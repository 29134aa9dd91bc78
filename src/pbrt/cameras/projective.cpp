#include "pbrt/cameras/projective.h"

#include <fmt/format.h>

namespace lacquer {

Camera::Camera(const Params& params, const AnimatedTransform& renderFromCamera)
    : renderFromCamera_(renderFromCamera),
      shutterOpen_(params.GetFloat("shutteropen", 0)),
      shutterClose_(params.GetFloat("shutterclose", 1)) {
    if (!(shutterClose_ > shutterOpen_) || !std::isfinite(shutterClose_ - shutterOpen_))
        params.Fail("shutterclose",
                    fmt::format("the shutter closes at {} but opens at {}; it must close later",
                                shutterClose_, shutterOpen_));
}

float Camera::ShutterTime(const Params& params) {
    return params.GetFloat("shutterclose", 1) - params.GetFloat("shutteropen", 0);
}

namespace {

struct ScreenWindow {
    float x0, x1, y0, y1;
};

ScreenWindow ReadScreenWindow(const CameraArgs& args) {
    const float aspect =
        args.params.GetFloat("frameaspectratio", float(args.resolution.x) / float(args.resolution.y));
    if (!(aspect > 0) || !std::isfinite(aspect))
        args.params.Fail("frameaspectratio",
                         fmt::format("frameaspectratio is {}; it must be positive", aspect));
    ScreenWindow window{-1, 1, -1, 1};
    if (aspect > 1)
        window = {-aspect, aspect, -1, 1};
    else
        window = {-1, 1, -1 / aspect, 1 / aspect};
    const std::vector<float> given = args.params.GetFloats("screenwindow");
    if (given.empty()) return window;
    if (given.size() != 4)
        args.params.Fail(
            "screenwindow",
            fmt::format("screenwindow has {} values; four are expected: x0 x1 y0 y1", given.size()));
    if (given[0] == given[1] || given[2] == given[3])
        args.params.Fail("screenwindow", "the screen window is empty");
    return {given[0], given[1], given[2], given[3]};
}

}  // namespace

ProjectiveCamera::ProjectiveCamera(const CameraArgs& args, const Transform& screenFromCamera)
    : Camera(args.params, args.renderFromCamera),
      screenFromCamera_(screenFromCamera),
      lensRadius_(args.params.GetFloat("lensradius", 0)),
      focalDistance_(args.params.GetFloat("focaldistance", 1e6f)) {
    if (!(lensRadius_ >= 0) || !std::isfinite(lensRadius_))
        args.params.Fail("lensradius", fmt::format("lensradius is {}; it must be zero or more", lensRadius_));
    // A pinhole is sharp at any distance, whatever the scene says.
    if (HasLens() && (!(focalDistance_ > 0) || !std::isfinite(focalDistance_)))
        args.params.Fail("focaldistance",
                         fmt::format("focaldistance is {}; it must be positive", focalDistance_));
    const ScreenWindow w = ReadScreenWindow(args);
    // Raster (0,0) is the top left corner; screen y points up.
    const Transform screenFromRaster = Transform::Translate({w.x0, w.y1, 0}) *
                                       Transform::Scale({(w.x1 - w.x0) / float(args.resolution.x),
                                                         -(w.y1 - w.y0) / float(args.resolution.y), 1});
    cameraFromRaster_ = screenFromCamera_.Inverse() * screenFromRaster;
    const Point3 corner = cameraFromRaster_.Point({0, 0, 0});
    dxCamera_ = cameraFromRaster_.Point({1, 0, 0}) - corner;
    dyCamera_ = cameraFromRaster_.Point({0, 1, 0}) - corner;
}

std::optional<Point2> ProjectiveCamera::RasterOf(Vec3 pCamera, bool isDirection) const {
    const glm::vec4 p =
        cameraFromRaster_.InverseMatrix() * glm::vec4(pCamera.x, pCamera.y, pCamera.z, isDirection ? 0 : 1);
    if (!(p.w > 0)) return std::nullopt;
    return Point2(p.x, p.y) / p.w;
}

std::optional<CameraRay> ProjectiveCamera::ToRenderSpace(const Point3 origins[3], const Vec3 directions[3],
                                                         float time) const {
    // In place: a copy of what was just written, in wider pieces, stalls.
    std::optional<CameraRay> ray(std::in_place);
    const auto apply = [&](const Transform& t) {
        ray->ray = {t.Point(origins[0]), Normalize(t.Vector(directions[0])), time};
        ray->rxOrigin = t.Point(origins[1]);
        ray->ryOrigin = t.Point(origins[2]);
        ray->rxDirection = Normalize(t.Vector(directions[1]));
        ray->ryDirection = Normalize(t.Vector(directions[2]));
    };
    if (renderFromCamera_.IsAnimated())
        apply(renderFromCamera_.At(time));
    else
        apply(renderFromCamera_.Start());
    return ray;
}

}  // namespace lacquer
