// Integrator "simplevolpath": a path tracer through media alone, without light samples and weights. Short
// enough to be verified by reading, a reference for tests.
//
//   "integer maxdepth"  5  scattering events of a path after which it ends
#include "pbrt/core/error.h"
#include "pbrt/integrators/medium_tracking.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

class SimpleVolPathIntegrator final : public Integrator {
  public:
    explicit SimpleVolPathIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          surroundings_(args) {
        for (const Light* light : scene_.Lights())
            if (light->IsDelta())
                throw SceneError(
                    args.params.Loc(),
                    "integrator \"simplevolpath\" finds light by chance, and never that of a point, spot, "
                    "goniometric, projection or distant light; use \"volpath\"");
        if (scene_.HasScatteringSurfaces())
            throw SceneError(
                args.params.Loc(),
                "integrator \"simplevolpath\" knows no surfaces but those of material \"interface\"; use "
                "\"volpath\"");
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler&,
                       ThreadState& state) const override {
        // Distances are drawn for one wavelength: the path carries no other.
        lambda.TerminateSecondary();
        SampledSpectrum L(0);
        float weight = 1;  // of what the path has scattered so far
        Ray ray = cameraRay.ray;
        const Medium* medium = scene_.CameraMedium();
        SurfaceInteraction si;
        TracedPath path = TracedPath::FromCamera(surroundings_, cameraRay, maxDepth_, state);
        for (;;) {
            const bool hit = path.Intersect(ray, &si);
            const float tMax = hit ? Dot(si.p - ray.o, ray.d) : kMaxRayDistance;
            bool scattered = false, absorbed = false;
            if (medium)
                TrackCollisions(*medium, ray, tMax, state.rng.Uniform(), state.rng, lambda,
                                [&](const MajorantCollision& at) {
                                    const MediumProperties& m = at.medium;
                                    const float u = state.rng.Uniform() * at.sigmaMaj[0];
                                    absorbed = u < m.sigma_a[0];
                                    scattered = !absorbed && u < m.sigma_a[0] + m.sigma_s[0];
                                    if (absorbed) L += weight * m.Le;
                                    if (scattered) {
                                        const PhaseSample sample =
                                            medium->Phase(lambda, state.arena).Sample(-ray.d, state.rng);
                                        weight *= sample.weight;
                                        ray = {at.p, sample.wi, ray.time};
                                    }
                                    return !absorbed && !scattered;
                                });
            if (absorbed) path.Cover(1);
            if (absorbed || (scattered && !path.ScatterInMedium())) return L;
            if (scattered) continue;
            if (!hit) {
                for (const Light* light : scene_.InfiniteLights()) L += weight * light->Le(ray, lambda);
                return L;
            }
            medium = si.MediumToward(ray.d, medium);
            ray = SpawnRay(si, ray.d);
        }
    }

    bool RendersMedia() const override { return true; }

  private:
    const Scene& scene_;
    int maxDepth_;
    PathSurroundings surroundings_;
};

std::unique_ptr<Integrator> CreateSimpleVolPath(const IntegratorArgs& args) {
    return std::make_unique<SimpleVolPathIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "simplevolpath", CreateSimpleVolPath);

}  // namespace lacquer
