// Integrator "lightpath": light tracing. Paths from the lights, each vertex of which is connected to the
// camera. Lights are chosen by their power. What no ray to the camera can show stays black: infinite lights
// as the background, and whatever is seen in smooth mirrors or through smooth glass; and so do media that
// glow.
//
//   "integer maxdepth"  5  scattering events of a path after which it ends
#include "pbrt/integrators/subpath.h"

namespace lacquer {
namespace {

class LightPathIntegrator final : public Integrator {
  public:
    explicit LightPathIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          surroundings_(args),
          emitters_(args.scene) {
        RequireImportance(args);
    }
    bool MakesSplats() const override { return true; }
    bool RendersMedia() const override { return true; }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        const SampledSpectrum black(0);
        if (state.firstHit) {
            // No path from a light follows the camera ray: what it meets is for the auxiliary outputs alone.
            SampledWavelengths seen = lambda;
            SurfaceInteraction si;
            TracedPath::FromCamera(surroundings_, cameraRay, 0, state)
                .FollowToSurface(cameraRay.ray, seen, &si);
        }
        const std::optional<LightStart> start = StartAtLight(emitters_, cameraRay.ray.time, lambda, sampler);
        if (!start) return black;
        Splat(ConnectToCamera(scene_, start->vertex, sampler.Get2D(), lambda, state), lambda, state);

        SubpathEdge edge = start->edge;
        PathVertex last = start->vertex;
        TracedPath path = TracedPath::FromLight(surroundings_, state);
        while (path.Depth() < maxDepth_) {
            PathVertex v;
            const Arrival arrival = FollowEdge(&edge, &path, &last, &v, lambda, sampler, state);
            if (arrival == Arrival::Passes) continue;
            if (arrival != Arrival::AtVertex) break;
            if (path.Depth() == 1 && !IsLit(start->vertex, v.si, lambda)) break;
            Splat(ConnectToCamera(scene_, v, sampler.Get2D(), lambda, state), lambda, state);
            if (!ScatterLight(&v, &edge, sampler, state)) break;

            // Russian roulette on what is left of the light.
            const float survival = edge.beta.MaxComponent() /
                                   (start->edge.beta.MaxComponent() * MeanPdf(edge.pdfs.scattering, lambda));
            if (path.Depth() > 1 && survival < 1) {
                if (sampler.Get1D() >= survival) break;
                edge.beta /= survival;
            }
        }
        return black;
    }

  private:
    static void Splat(const std::optional<CameraArrival>& arrival, const SampledWavelengths& lambda,
                      ThreadState& state) {
        if (arrival && !state.film->AddSplat(arrival->camera.pFilm, arrival->L, lambda)) ++state.badSamples;
    }

    const Scene& scene_;
    int maxDepth_;
    PathSurroundings surroundings_;
    EmitterTable emitters_;
};

std::unique_ptr<Integrator> CreateLightPath(const IntegratorArgs& args) {
    return std::make_unique<LightPathIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(
    IntegratorKind, "lightpath", CreateLightPath,
    {.neverFinds =
         "infinite lights as the background, nor media that glow, nor what is seen in smooth mirrors and "
         "through smooth glass",
     .makesSplats = true});

}  // namespace lacquer
