// Camera "orthographic": parallel projection along +z; one screen unit is one unit of camera space.
//
//   "float screenwindow" [4]                   from the image  x0 x1 y0 y1 on the screen, on which the
//                                                              image's shorter axis spans [-1, 1]
//   "float frameaspectratio"                   from the image  width over height of that screen
//   "float lensradius"                         0               of the thin lens, >= 0; 0: a pinhole
//   "float focaldistance"                      1e6             distance of the plane in focus, > 0
//   "float shutteropen", "float shutterclose"  0, 1            when the shutter opens and closes [s]
#include "pbrt/cameras/projective.h"

namespace lacquer {
namespace {

class OrthographicCamera final : public ProjectiveCamera {
  public:
    explicit OrthographicCamera(const CameraArgs& args) : ProjectiveCamera(args, Transform()) {}

    std::optional<CameraRay> GenerateRay(const CameraSample& sample) const override {
        const Point3 pCamera = cameraFromRaster_.Point({sample.pFilm.x, sample.pFilm.y, 0});
        Point3 origins[3] = {pCamera, pCamera + dxCamera_, pCamera + dyCamera_};
        Vec3 directions[3] = {Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3(0, 0, 1)};
        if (HasLens())
            for (int i = 0; i < 3; ++i) ApplyLens(sample.pLens, &origins[i], &directions[i]);
        return ToRenderSpace(origins, directions, TimeOf(sample.time));
    }
};

std::unique_ptr<Camera> CreateOrthographic(const CameraArgs& args) {
    return std::make_unique<OrthographicCamera>(args);
}

}  // namespace

LACQUER_REGISTER(CameraKind, "orthographic", CreateOrthographic);

}  // namespace lacquer
