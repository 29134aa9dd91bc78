// Integrator "lightpath": light tracing. Paths from the lights, each vertex of which is connected to the
// camera. Lights are chosen by their power. What no ray to the camera can show stays black: infinite lights
// as the background, and whatever is seen in smooth mirrors or through smooth glass; and so do media that
// glow.
//
//   "integer maxdepth"  5  scattering events of a path after which it ends
#include "pbrt/integrators/subpath.h"
#include "pbrt/integrators/substitutes.h"

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
        // No path from a light follows the camera ray.
        RecordFirstHit(surroundings_, cameraRay, lambda, sampler, state);
        const SampledSpectrum black(0);
        const std::optional<LightStart> start = StartAtLight(emitters_, cameraRay.ray.time, lambda, sampler);
        if (!start) return black;
        Splat(ConnectToCamera(scene_, start->vertex, sampler.Get2D(), lambda, state), lambda, state);

        SubpathEdge edge = start->edge;
        const float emitted = edge.Carried();
        PathVertex v;
        TracedPath path = TracedPath::FromLight(surroundings_, state);
        while (path.Depth() < maxDepth_) {
            const Arrival arrival = FollowEdge(&edge, &path, nullptr, &v, lambda, sampler, state);
            if (arrival == Arrival::Passes) continue;
            if (arrival != Arrival::AtVertex) break;
            if (path.Depth() == 1 && !IsLit(start->vertex, v.si, lambda)) break;
            Splat(ConnectToCamera(scene_, v, sampler.Get2D(), lambda, state), lambda, state);
            if (!ScatterLight(&v, &edge, sampler, state)) break;

            // Russian roulette on what is left of the light.
            const float survival = edge.Carried() / emitted;
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
    if (const std::string why = WhyNoLightPaths(args.scene); !why.empty()) {
        return VolPathInstead(args, "integrator \"lightpath\" " + why);
    }
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
