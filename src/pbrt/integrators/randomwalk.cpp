// Integrator "randomwalk": uniformly random directions and emission found by chance. The simplest estimator
// there is, a reference for tests.
//
//   "integer maxdepth"  5  scattering events of a path after which it ends
#include "pbrt/core/sampling.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

class RandomWalkIntegrator final : public Integrator {
  public:
    explicit RandomWalkIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          surroundings_(args) {}

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        SampledSpectrum L(0), beta(1);
        Ray ray = cameraRay.ray;
        SurfaceInteraction si;
        Bsdf bsdf;
        TracedPath path = TracedPath::FromCamera(surroundings_, cameraRay, maxDepth_, state);
        while (beta) {
            if (!path.Intersect(ray, &si)) {
                for (const Light* light : scene_.InfiniteLights()) L += beta * light->Le(ray, lambda);
                break;
            }
            if (si.areaLight) L += beta * si.areaLight->L(si.p, si.n, si.uv, si.wo, lambda);
            const AtSurface at = path.Scatter(&si, lambda, &bsdf);
            if (at == AtSurface::Ends) break;
            if (at == AtSurface::Passes) {
                ray = SpawnRay(si, ray.d);
                continue;
            }
            const Vec3 wi = SampleUniformSphere(sampler.Get2D());
            const BxDFContext context = state.Context(false);
            beta *= bsdf.Evaluate(wi, context).f * (AbsDot(wi, si.shading.n) / PdfUniformSphere());
            ray = SpawnRay(si, wi);
        }
        return L;
    }

  private:
    const Scene& scene_;
    int maxDepth_;
    PathSurroundings surroundings_;
};

std::unique_ptr<Integrator> CreateRandomWalk(const IntegratorArgs& args) {
    return std::make_unique<RandomWalkIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "randomwalk", CreateRandomWalk,
                 {.neverFinds = "what is seen in smooth mirrors and through smooth glass",
                  .findsDeltaLights = false});

}  // namespace lacquer
