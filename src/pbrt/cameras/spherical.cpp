// Camera "spherical": all directions from one point; +y of camera space is up.
//
//   "string mapping"                           equalarea  "equalarea" (octahedral: +y at the centre, -y at
//                                                         the corners) or "equirectangular" (+y along the
//                                                         upper edge, -y along the lower one, azimuth from
//                                                         left to right)
//   "float shutteropen", "float shutterclose"  0, 1       when the shutter opens and closes [s]
#include "pbrt/base/camera.h"

namespace lacquer {
namespace {

enum class SphericalMapping { EqualArea, Equirectangular };

/// Direction at polar angle pi v from +z and azimuth 2 pi u. Beyond the poles it goes on along the meridian.
Vec3 EquirectangularToSphere(Point2 uv) {
    const float theta = Pi * uv.y;
    return SphericalDirection(std::sin(theta), std::cos(theta), 2 * Pi * uv.x);
}

/// Direction of the octahedral map, which beyond an edge goes on with the same edge turned over: that repeats
/// itself every two units.
Vec3 UnfoldedEqualAreaToSphere(Point2 uv) {
    return EqualAreaSquareToSphere(WrapEqualAreaSquare(uv - 2.f * glm::floor(uv / 2.f)));
}

class SphericalCamera final : public Camera {
  public:
    SphericalCamera(const CameraArgs& args, SphericalMapping mapping)
        : Camera(args.params, args.renderFromCamera), mapping_(mapping), resolution_(args.resolution) {}

    bool ReadsLens() const override { return false; }
    std::optional<CameraRay> GenerateRay(const CameraSample& sample) const override {
        const float time = TimeOf(sample.time);
        return renderFromCamera_.IsAnimated() ? RayThrough(sample.pFilm, time, renderFromCamera_.At(time))
                                              : RayThrough(sample.pFilm, time, renderFromCamera_.Start());
    }

  private:
    CameraRay RayThrough(Point2 pFilm, float time, const Transform& renderFromCamera) const {
        const auto direction = [&](Point2 p) {
            return Normalize(renderFromCamera.Vector(DirectionAt(p / resolution_)));
        };
        CameraRay r;
        r.ray = {renderFromCamera.Point(Point3(0)), direction(pFilm), time};
        r.rxOrigin = r.ryOrigin = r.ray.o;
        r.rxDirection = direction(pFilm + Point2(1, 0));
        r.ryDirection = direction(pFilm + Point2(0, 1));
        return r;
    }
    /// Unit, in camera space. The filter brings points from beyond the edges of the image too.
    Vec3 DirectionAt(Point2 uv) const {
        const Vec3 d = mapping_ == SphericalMapping::EqualArea ? UnfoldedEqualAreaToSphere(uv)
                                                               : EquirectangularToSphere(uv);
        // The pole of both maps is z, that of the camera y.
        return {d.x, d.z, d.y};
    }

    SphericalMapping mapping_;
    Vec2 resolution_;
};

std::unique_ptr<Camera> CreateSpherical(const CameraArgs& args) {
    const std::string mapping =
        args.params.GetChoice("mapping", "equalarea", {"equalarea", "equirectangular"});
    // Scenes may carry what other cameras need.
    for (const char* name : {"lensradius", "focaldistance", "frameaspectratio", "screenwindow"})
        args.params.Ignore("float", name);
    return std::make_unique<SphericalCamera>(
        args, mapping == "equalarea" ? SphericalMapping::EqualArea : SphericalMapping::Equirectangular);
}

}  // namespace

LACQUER_REGISTER(CameraKind, "spherical", CreateSpherical);

}  // namespace lacquer
