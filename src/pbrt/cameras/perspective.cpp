// The pinhole or thin-lens camera. `fov` is the full angle over the shorter image axis.
#include "pbrt/cameras/projective.h"

#include <fmt/format.h>

namespace lacquer {
namespace {

class PerspectiveCamera final : public ProjectiveCamera {
  public:
    PerspectiveCamera(const CameraArgs& args, float fovDeg)
        : ProjectiveCamera(args, ScreenFromCamera(fovDeg)) {}

    std::optional<CameraRay> GenerateRay(const CameraSample& sample) const override {
        const Point3 pCamera = cameraFromRaster_.Point({sample.pFilm.x, sample.pFilm.y, 0});
        Point3 origins[3] = {Point3(0), Point3(0), Point3(0)};
        Vec3 directions[3] = {Normalize(pCamera), Normalize(pCamera + dxCamera_),
                              Normalize(pCamera + dyCamera_)};
        if (HasLens())
            for (int i = 0; i < 3; ++i) ApplyLens(sample.pLens, &origins[i], &directions[i]);
        return ToRenderSpace(origins, directions, TimeOf(sample.time));
    }

  private:
    // Projection onto the plane z = 1 scaled by 1/tan(fov/2); depth is mapped from [near, far] to [0, 1].
    static Transform ScreenFromCamera(float fovDeg) {
        constexpr float kNear = 1e-2f, kFar = 1000;
        glm::mat4 projection(0.f);
        projection[0][0] = projection[1][1] = 1 / std::tan(Radians(fovDeg) / 2);
        projection[2][2] = kFar / (kFar - kNear);
        projection[3][2] = -kFar * kNear / (kFar - kNear);
        projection[2][3] = 1;
        return Transform(projection);
    }
};

std::unique_ptr<Camera> CreatePerspective(const CameraArgs& args) {
    const float fov = args.params.GetFloat("fov", 90);
    if (!(fov > 0 && fov < 180))
        args.params.Fail("fov", fmt::format("fov is {} degrees; it must lie between 0 and 180", fov));
    return std::make_unique<PerspectiveCamera>(args, fov);
}

}  // namespace

LACQUER_REGISTER(CameraKind, "perspective", CreatePerspective);

}  // namespace lacquer
