// Integrator "bdpt": bidirectional path tracing [Veach 1997, ch. 10]. A path from the camera and one from a
// light are connected at all pairs of vertices, and the connections are weighted against each other by the
// power heuristic. Lights are chosen by their power.
//
//   "integer maxdepth"                                   5      scattering events of a path after which it
//                                                               ends
//   "bool regularize"                                    false  widens narrow lobes after the first diffuse
//                                                               or glossy event of a path
//   "bool visualizestrategies", "bool visualizeweights"  false  are refused when true: images of single
//                                                               strategies are not supported
//
// Light of media that glow is found by paths from the camera alone.
#include "pbrt/integrators/bidirectional.h"
#include "pbrt/integrators/substitutes.h"

namespace lacquer {
namespace {

class BdptIntegrator final : public Integrator {
  public:
    explicit BdptIntegrator(const IntegratorArgs& args)
        : maxDepth_(size_t(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20))),
          strategies_(args, args.params.GetBool("regularize", false), true) {
        for (const char* name : {"visualizestrategies", "visualizeweights"})
            if (args.params.GetBool(name, false))
                args.params.Fail(name, "images of single strategies are not in Lacquer");
        RequireImportance(args);
    }
    bool MakesSplats() const override { return true; }
    bool RendersMedia() const override { return true; }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        Subpath cameraPath(state.arena), lightPath(state.arena);
        strategies_.TraceCameraPath(cameraPath, maxDepth_ + 2, cameraRay, lambda, sampler, state);
        strategies_.TraceLightPath(lightPath, maxDepth_ + 1, cameraRay.ray.time, lambda, sampler, state);

        SampledSpectrum L(0);
        for (size_t t = 1; t <= cameraPath.Size(); ++t) {
            if (t > 1) L += strategies_.Emission(lightPath, cameraPath, t, lambda);
            L += BidirectionalStrategies::Glow(cameraPath, t + 1);
            if (t > 1 && t <= maxDepth_ + 1 && IsConnectible(cameraPath[t - 1]))
                L += strategies_.DirectLight(lightPath, cameraPath, t, lambda, sampler, state);
            const size_t most = std::min(lightPath.Size(), maxDepth_ + 2 - std::min(t, maxDepth_ + 2));
            for (size_t s = 2; s <= most; ++s) {
                if (!IsConnectible(lightPath[s - 1])) continue;
                if (t == 1)
                    Splat(strategies_.CameraLight(lightPath, cameraPath, s, lambda, sampler, state), lambda,
                          state);
                else if (IsConnectible(cameraPath[t - 1]))
                    L += strategies_.Connect(lightPath, cameraPath, s, t, lambda, state);
            }
        }
        return L;
    }

  private:
    static void Splat(const std::optional<FilmLight>& light, const SampledWavelengths& lambda,
                      ThreadState& state) {
        if (light && !state.film->AddSplat(light->p, light->L, lambda)) ++state.badSamples;
    }

    size_t maxDepth_;
    BidirectionalStrategies strategies_;
};

std::unique_ptr<Integrator> CreateBdpt(const IntegratorArgs& args) {
    if (const std::string why = WhyNoLightPaths(args.scene); !why.empty()) {
        for (const char* name : {"visualizestrategies", "visualizeweights"}) args.params.Ignore("bool", name);
        return VolPathInstead(args, "integrator \"bdpt\" " + why);
    }
    return std::make_unique<BdptIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "bdpt", CreateBdpt, {.makesSplats = true});

}  // namespace lacquer
