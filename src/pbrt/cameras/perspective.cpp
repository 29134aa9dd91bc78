// Camera "perspective": a pinhole or a thin lens.
//
//   "float fov"                                90              full angle over the shorter axis of the image,
//                                                              in (0, 180) [degrees]
//   "float screenwindow" [4]                   from the image  x0 x1 y0 y1 on the screen, on which the
//                                                              image's shorter axis spans [-1, 1]
//   "float frameaspectratio"                   from the image  width over height of that screen
//   "float lensradius"                         0               of the thin lens, >= 0; 0: a pinhole
//   "float focaldistance"                      1e6             distance of the plane in focus, > 0
//   "float shutteropen", "float shutterclose"  0, 1            when the shutter opens and closes [s]
#include "pbrt/cameras/projective.h"

#include <fmt/format.h>

namespace lacquer {
namespace {

class PerspectiveCamera final : public ProjectiveCamera {
  public:
    PerspectiveCamera(const CameraArgs& args, float fovDeg)
        : ProjectiveCamera(args, ScreenFromCamera(fovDeg)) {
        // Raster points lie on one plane across the axis; the image is measured where that is at z = 1.
        const float z = cameraFromRaster_.Point({0, 0, 0}).z;
        imageArea_ = Length(Cross(dxCamera_, dyCamera_)) / Sqr(z) * float(args.resolution.x) *
                     float(args.resolution.y);
        keepsAngles_ = KeepsAngles(renderFromCamera_.Start()) && KeepsAngles(renderFromCamera_.End());
    }

    std::optional<CameraRay> GenerateRay(const CameraSample& sample) const override {
        const Point3 pCamera = cameraFromRaster_.Point({sample.pFilm.x, sample.pFilm.y, 0});
        Point3 origins[3] = {Point3(0), Point3(0), Point3(0)};
        Vec3 directions[3] = {pCamera, pCamera + dxCamera_, pCamera + dyCamera_};
        if (HasLens())
            for (int i = 0; i < 3; ++i) ApplyLens(sample.pLens, &origins[i], &directions[i]);
        return ToRenderSpace(origins, directions, TimeOf(sample.time));
    }

    // With theta from the axis, an element of the plane z = 1 that the ray from any point of the lens images
    // has cos^3(theta) of solid angle: the density is 1 / (A cos^3), and W, whose integral has one more
    // cosine and the lens area, 1 / (A lens cos^4).
    std::optional<CameraConnection> SampleWi(Point3 from, float time, Point2 u) const override {
        const Transform t = renderFromCamera_.At(time);
        const Point3 target = t.InversePoint(from);
        Point3 lens(0);
        if (HasLens()) {
            const Point2 onLens = lensRadius_ * SampleUniformDiskConcentric(u);
            lens = {onLens.x, onLens.y, 0};
        }
        const Vec3 d = target - lens;
        if (!(d.z > 0)) return std::nullopt;
        const float cosTheta = d.z / Length(d);
        const Point3 inFocus = lens + d * ((HasLens() ? focalDistance_ : d.z) / d.z);
        const Point3 raster = cameraFromRaster_.InversePoint(inFocus);

        CameraConnection c;
        c.p = t.Point(lens);
        const Vec3 toLens = c.p - from;
        const float distanceSquared = LengthSquared(toLens);
        if (!(distanceSquared > 0)) return std::nullopt;
        c.wi = toLens / std::sqrt(distanceSquared);
        c.pFilm = {raster.x, raster.y};
        // The lens is measured in camera space; its unit cancels in importance / pdf.
        const float lensArea = HasLens() ? Pi * Sqr(lensRadius_) : 1.f;
        c.importance = 1 / (imageArea_ * lensArea * Sqr(Sqr(cosTheta)));
        c.pdf = distanceSquared / (cosTheta * lensArea);
        return c;
    }
    float PdfWe(const Ray& ray) const override {
        const Vec3 d = renderFromCamera_.At(ray.time).InverseVector(ray.d);
        if (!(d.z > 0)) return 0;
        const float cosTheta = d.z / Length(d);
        return 1 / (imageArea_ * cosTheta * cosTheta * cosTheta);
    }
    std::string WhyNoImportance() const override {
        if (keepsAngles_) return {};
        return "light can be traced to the camera only where the camera's transformation keeps angles";
    }

  private:
    /// True for rotations, translations, mirrorings and one scale for all axes.
    static bool KeepsAngles(const Transform& t) {
        const glm::mat3 m(t.Matrix());
        const glm::mat3 gram = glm::transpose(m) * m;
        const float size = gram[0][0];
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                if (!(std::abs(gram[c][r] - (c == r ? size : 0.f)) <= 1e-3f * size)) return false;
        return true;
    }

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

    float imageArea_ = 1;  ///< of the full image on the plane z = 1 of camera space
    bool keepsAngles_ = true;
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
