// From film positions to rays.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/transform.h"

namespace lacquer {

/// Numbers for one camera ray.
struct CameraSample {
    Point2 pFilm{0};     ///< pixels from the top left of the full image
    Point2 pLens{0.5f};  ///< [0,1)^2
    float time = 0;      ///< [0,1): fraction of the shutter interval
};

/// A camera ray with the rays of the neighbouring pixels.
struct CameraRay {
    Ray ray;  ///< d is unit
    float weight = 1;
    Point3 rxOrigin{0}, ryOrigin{0};  ///< one pixel to the right, one pixel down
    Vec3 rxDirection{0, 0, 1}, ryDirection{0, 0, 1};
};

/// A point of the lens as seen from a point of the scene.
struct CameraConnection {
    Point3 p{0};           ///< on the lens, rendering space
    Vec3 wi{0, 0, 1};      ///< unit, toward p
    Point2 pFilm{0};       ///< where the ray from p meets the film [pixels]; may lie outside of the image
    float importance = 0;  ///< W, see Camera::SampleWi() [1/(m^2 sr)], or [1/sr] of a pinhole
    float pdf = 0;         ///< [1/sr] at the point of the scene; of a pinhole the Jacobian of a delta
};

/// Immutable, thread-safe. Camera space is left-handed: +x right, +y up, +z into the scene.
class Camera {
  public:
    virtual ~Camera() = default;
    /// Empty where no light can arrive (vignetting).
    virtual std::optional<CameraRay> GenerateRay(const CameraSample& sample) const = 0;
    /// False if rays are the same whatever pLens is.
    virtual bool ReadsLens() const { return true; }
    const AnimatedTransform& RenderFromCamera() const { return renderFromCamera_; }
    float ShutterOpen() const { return shutterOpen_; }
    float ShutterClose() const { return shutterClose_; }
    /// Draws a point of the lens for a point of the scene. The importance W is such that the integral of W L
    /// cos over lens and directions is the mean of L over the whole image, every point of which is seen with
    /// weight 1; beyond the edges, where filters reach to, it goes on. Empty for points behind the lens.
    virtual std::optional<CameraConnection> SampleWi(Point3 /*from*/, float /*time*/, Point2 /*u*/) const {
        return std::nullopt;
    }
    /// Density over solid angle [1/sr] of camera rays along a direction from any point of the lens, the film
    /// position being uniform over the image.
    virtual float PdfWe(const Ray& /*ray*/) const { return 0; }
    /// Why the two above do not work; empty if they do.
    virtual std::string WhyNoImportance() const {
        return "light can be traced to the perspective camera only";
    }
    /// Where the image shows a point, or what lies infinitely far into a direction, both of camera space, by
    /// the middle of the lens [pixels]; may lie outside of the image. Empty for what is behind the camera.
    virtual std::optional<Point2> RasterOf(Vec3 /*pCamera*/, bool /*isDirection*/) const { return {}; }
    /// Why it does not work; empty if it does.
    virtual std::string WhyNoRaster() const { return "this camera does not know where it shows a point"; }
    /// Raster to camera space of a projective camera, for image metadata; identity if there is none.
    virtual Transform CameraFromRaster() const { return {}; }
    /// Screen (-1..1 over the image) from camera space, for metadata; empty if no matrix does that.
    virtual std::optional<Transform> ScreenFromCamera() const { return {}; }

    /// How long the shutter of a camera with these parameters is open [s]; of one that is wrong, 0 or less.
    static float ShutterTime(const Params& params);

  protected:
    /// Reads shutteropen and shutterclose.
    Camera(const Params& params, const AnimatedTransform& renderFromCamera);
    float TimeOf(float u) const { return Lerp(u, shutterOpen_, shutterClose_); }

    AnimatedTransform renderFromCamera_;
    float shutterOpen_, shutterClose_;
};

struct CameraArgs {
    const Params& params;
    AnimatedTransform renderFromCamera;
    Int2 resolution;                     ///< of the full image
    float filmDiagonal = 35;             ///< [mm]
    class Observer* observer = nullptr;  ///< for warnings; may be null
};
struct CameraKind {
    static constexpr const char* kKind = "camera";
    using Factory = std::unique_ptr<Camera> (*)(const CameraArgs&);
};

}  // namespace lacquer
