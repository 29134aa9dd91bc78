// Camera "realistic": a lens of glass; rays from the film are traced through its surfaces.
//
//   "string lensfile"                          required  surfaces from the scene to the film: see
//                                                        ReadLensFile()
//   "float aperturediameter"                   1         of the stop [mm]; at most what the lens file says
//   "float focusdistance"                      10        from the film to what is in focus [scene units,
//                                                        which are metres]
//   "string aperture"                          round     shape of the stop: "gaussian", "square", "pentagon",
//                                                        "star", or an image
//   "float shutteropen", "float shutterclose"  0, 1      when the shutter opens and closes [s]
//
// The size of the film is that of the film's "float diagonal" [mm]. It lies in the plane z = 0 of camera
// space. The weight of a ray is the exposure of the film per radiance, not normalised to 1.
#include <fmt/format.h>

#include "pbrt/base/camera.h"
#include "pbrt/cameras/realistic_aperture.h"
#include "pbrt/cameras/realistic_lens.h"
#include "pbrt/core/progress.h"

namespace lacquer {
namespace {

constexpr float kMetresPerMillimetre = 1e-3f;

class RealisticCamera final : public Camera {
  public:
    RealisticCamera(const CameraArgs& args, LensSystem lens, std::optional<ApertureMask> mask)
        : Camera(args.params, args.renderFromCamera),
          lens_(std::move(lens)),
          mask_(std::move(mask)),
          pupils_(lens_, args.filmDiagonal / 2, mask_ ? mask_->Extent() : 1) {
        const Vec2 resolution(args.resolution);
        pixelSize_ = args.filmDiagonal / std::hypot(resolution.x, resolution.y);
        filmCentre_ = resolution / 2.f;
    }

    std::optional<CameraRay> GenerateRay(const CameraSample& sample) const override {
        // The lens turns the image upside down and left to right; raster y already points down.
        const Point2 film(pixelSize_ * (filmCentre_.x - sample.pFilm.x),
                          pixelSize_ * (sample.pFilm.y - filmCentre_.y));
        float area = 0;
        const Point2 rear = SamplePupil(film, sample.pLens, &area);
        LensRays rays = StartRays(film, rear);
        const float cosTheta = rays.dz[0];

        const LensSystem::Stops stops = mask_ ? LensSystem::Stops::Ignore : LensSystem::Stops::Block;
        const LensRays::Mask alive = lens_.Trace(&rays, 1, stops);
        if (!alive[0]) return std::nullopt;
        // Irradiance on the film per area of the plane that the point was drawn in.
        float weight = area * Sqr(Sqr(cosTheta) / lens_.RearZ());
        if (mask_) weight *= mask_->At({rays.stopX[0], rays.stopY[0]});
        if (!(weight > 0)) return std::nullopt;
        const float time = TimeOf(sample.time);
        return renderFromCamera_.IsAnimated() ? ToRay(rays, alive, weight, time, renderFromCamera_.At(time))
                                              : ToRay(rays, alive, weight, time, renderFromCamera_.Start());
    }

  private:
    /// A point of the plane of the rear vertex, uniform in the box of the exit pupil.
    Point2 SamplePupil(Point2 film, Point2 u, float* area) const {
        const float radius = std::hypot(film.x, film.y);
        const ExitPupils::Box& box = pupils_.At(radius);
        *area = box.Area();
        const Point2 p = box.min + u * (box.max - box.min);
        // The box is that of a film point on the +x axis.
        const Vec2 axis = radius > 0 ? film / radius : Vec2(1, 0);
        return {axis.x * p.x - axis.y * p.y, axis.y * p.x + axis.x * p.y};
    }

    /// The ray in lane 0, those of the pixels to the right and below in lanes 1 and 2, through one point of
    /// the pupil.
    LensRays StartRays(Point2 film, Point2 rear) const {
        LensRays rays{};
        rays.ox = LensRays::Lanes{film.x, film.x - pixelSize_, film.x, film.x};
        rays.oy = LensRays::Lanes{film.y, film.y, film.y + pixelSize_, film.y};
        const float z = lens_.RearZ();
        for (int i = 0; i < LensRays::kCount; ++i) {
            const Vec3 d = Normalize(Vec3(rear.x - rays.ox[i], rear.y - rays.oy[i], z));
            rays.dx[i] = d.x, rays.dy[i] = d.y, rays.dz[i] = d.z;
        }
        return rays;
    }

    static CameraRay ToRay(const LensRays& rays, const LensRays::Mask& alive, float weight, float time,
                           const Transform& renderFromCamera) {
        // A neighbour that misses a surface is replaced by the other one, which is as far away.
        const int right = alive[1] ? 1 : alive[2] ? 2 : 0, below = alive[2] ? 2 : right;
        const auto origin = [&](int i) {
            return renderFromCamera.Point(kMetresPerMillimetre * Point3(rays.ox[i], rays.oy[i], rays.oz[i]));
        };
        const auto direction = [&](int i) {
            return Normalize(renderFromCamera.Vector({rays.dx[i], rays.dy[i], rays.dz[i]}));
        };
        CameraRay r;
        r.ray = {origin(0), direction(0), time};
        r.weight = weight;
        r.rxOrigin = origin(right);
        r.ryOrigin = origin(below);
        r.rxDirection = direction(right);
        r.ryDirection = direction(below);
        return r;
    }

    LensSystem lens_;
    std::optional<ApertureMask> mask_;
    ExitPupils pupils_;
    float pixelSize_ = 0;   ///< [mm]
    Point2 filmCentre_{0};  ///< [pixels]
};

std::optional<ApertureMask> ReadAperture(const Params& params) {
    const std::string name = params.GetString("aperture", "");
    if (name.empty()) return std::nullopt;
    if (auto mask = ApertureMask::Named(name)) return mask;
    const FileLoc loc = params.LocOf("aperture");
    // A name without an extension is meant to be a shape.
    if (name.find('.') == std::string::npos)
        params.Fail("aperture", fmt::format("unknown aperture \"{}\"; expected {} or an image file{}",
                                            Excerpt(name), fmt::join(ApertureMask::Names(), ", "),
                                            DidYouMean(name, ApertureMask::Names())));
    const std::string path = params.PathOf("aperture");
    try {
        return ApertureMask(ReadImage(path, ColorEncoding{ColorEncoding::Kind::SRGB}, loc));
    } catch (const std::invalid_argument& e) {
        throw SceneError(loc, fmt::format("{}: the aperture {}", path, e.what()));
    }
}

float ReadPositive(const Params& params, const char* name, float fallback, const char* unit) {
    const float value = params.GetFloat(name, fallback);
    if (!(value > 0)) params.Fail(name, fmt::format("{} is {} {}; it must be positive", name, value, unit));
    return value;
}

/// Diameter of the smallest stop in the file; infinite without one.
float StopDiameter(const std::vector<LensSurface>& surfaces) {
    float diameter = Infinity;
    for (const LensSurface& s : surfaces)
        if (s.radius == 0) diameter = std::min(diameter, s.diameter);
    return diameter;
}

std::unique_ptr<Camera> CreateRealistic(const CameraArgs& args) {
    const Params& params = args.params;
    const std::string file = params.GetString("lensfile", "");
    const float stopDiameter = ReadPositive(params, "aperturediameter", 1, "mm");
    const float focusDistance = ReadPositive(params, "focusdistance", 10, "m");
    std::optional<ApertureMask> mask = ReadAperture(params);
    if (file.empty()) params.Fail("lensfile", "camera \"realistic\" needs \"string lensfile\"");

    const std::string path = params.PathOf("lensfile");
    const std::vector<LensSurface> surfaces = ReadLensFile(path, params.LocOf("lensfile"));
    LensSystem lens(surfaces, stopDiameter);
    const float widest = StopDiameter(surfaces);
    if (args.observer && params.Has("aperturediameter") && stopDiameter > widest)
        args.observer->Warn(
            fmt::format("{}: warning: aperturediameter is {} mm, but the stop of the lens opens to {} mm "
                        "only; that is used",
                        params.LocOf("aperturediameter").ToString(), stopDiameter, widest));

    const float focalLength = lens.Cardinals().focalLength;
    if (!(focalLength > 0) || !std::isfinite(focalLength))
        throw SceneError({path, 0, 0},
                         fmt::format("the lens makes no image: its focal length is {} mm", focalLength));
    if (!lens.Focus(focusDistance / kMetresPerMillimetre))
        params.Fail(
            "focusdistance",
            fmt::format(
                "focusdistance is {} m from the film; this lens of {:.4g} mm focuses from {:.4g} m on",
                focusDistance, focalLength, lens.NearestFocus() * kMetresPerMillimetre));
    return std::make_unique<RealisticCamera>(args, std::move(lens), std::move(mask));
}

}  // namespace

LACQUER_REGISTER(CameraKind, "realistic", CreateRealistic);

}  // namespace lacquer
