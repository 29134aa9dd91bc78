// Integrator "simplepath": a path tracer without multiple importance sampling. Short enough to be verified by
// reading, a reference for tests.
//
//   "integer maxdepth"   5     scattering events of a path after which it ends
//   "bool samplelights"  true  next-event estimation; false: emission is found by chance
//   "bool samplebsdf"    true  directions by the BxDF; false: uniform
#include "pbrt/core/sampling.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

class SimplePathIntegrator final : public Integrator {
  public:
    explicit SimplePathIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          sampleLights_(args.params.GetBool("samplelights", true)),
          sampleBsdf_(args.params.GetBool("samplebsdf", true)),
          surroundings_(args) {}

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        SampledSpectrum L(0), beta(1);
        Ray ray = cameraRay.ray;
        bool specularBounce = true;
        SurfaceInteraction si;
        Bsdf bsdf;
        TracedPath path = TracedPath::FromCamera(surroundings_, cameraRay, maxDepth_, state);
        while (beta) {
            // Emission found by chance counts only where no light was sampled for it.
            const bool countEmission = !sampleLights_ || specularBounce;
            if (!path.Intersect(ray, &si)) {
                if (countEmission)
                    for (const Light* light : scene_.InfiniteLights()) L += beta * light->Le(ray, lambda);
                break;
            }
            if (countEmission && si.areaLight) L += beta * si.areaLight->L(si.p, si.n, si.uv, si.wo, lambda);
            const AtSurface at = path.Scatter(&si, lambda, &bsdf);
            if (at == AtSurface::Ends) break;
            if (at == AtSurface::Passes) {
                specularBounce = true;
                ray = SpawnRay(si, ray.d);
                continue;
            }
            const BxDFContext context = state.Context(false);
            if (sampleLights_ && !scene_.Lights().empty())
                L += beta * DirectLight(si, bsdf, context, lambda, sampler, state);

            if (sampleBsdf_) {
                const float uLobe = sampler.Get1D();
                const std::optional<BxDFSample> sample = bsdf.Sample({uLobe, sampler.Get2D()}, context);
                if (!sample) break;
                beta *= sample->weight;
                specularBounce = sample->IsSpecular();
                ray = SpawnRay(si, sample->wi);
            } else {
                const Vec3 wi = UniformDirection(si, bsdf.Flags(), sampler, &beta);
                beta *= bsdf.Evaluate(wi, context).f * AbsDot(wi, si.shading.n);
                specularBounce = false;
                ray = SpawnRay(si, wi);
            }
        }
        return L;
    }

  private:
    /// A uniform direction over the sphere, or the hemisphere of wo for materials that only reflect.
    static Vec3 UniformDirection(const SurfaceInteraction& si, Lobes flags, Sampler& sampler,
                                 SampledSpectrum* beta) {
        const Point2 u = sampler.Get2D();
        if (Any(flags, Lobes::Reflection) && Any(flags, Lobes::Transmission)) {
            *beta /= PdfUniformSphere();
            return SampleUniformSphere(u);
        }
        *beta /= PdfUniformHemisphere();
        const Vec3 wi = Frame::FromZ(si.shading.n).FromLocal(SampleUniformHemisphere(u));
        const bool sameSide = Dot(si.wo, si.shading.n) * Dot(wi, si.shading.n) > 0;
        return sameSide == Any(flags, Lobes::Reflection) ? wi : -wi;
    }

    SampledSpectrum DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, const BxDFContext& context,
                                const SampledWavelengths& lambda, Sampler& sampler,
                                ThreadState& state) const {
        const auto& lights = scene_.Lights();
        const size_t index = std::min(size_t(sampler.Get1D() * float(lights.size())), lights.size() - 1);
        const std::optional<LightSample> ls =
            lights[index]->SampleLi(LightReference(si), sampler.Get2D(), lambda);
        if (!ls) return SampledSpectrum(0);
        const SampledSpectrum f = bsdf.Evaluate(ls->wi, context).f * AbsDot(ls->wi, si.shading.n);
        if (!f || !scene_.Visible(si, *ls, false, state.rays)) return SampledSpectrum(0);
        return f * ls->L * (float(lights.size()) / ls->pdf);
    }

    const Scene& scene_;
    int maxDepth_;
    bool sampleLights_, sampleBsdf_;
    PathSurroundings surroundings_;
};

std::unique_ptr<Integrator> CreateSimplePath(const IntegratorArgs& args) {
    return std::make_unique<SimplePathIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "simplepath", CreateSimplePath, {.shadowsOfInterfaces = true});

}  // namespace lacquer
