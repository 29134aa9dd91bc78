// The unidirectional path tracer with next-event estimation and multiple importance sampling [Veach 1997].
#include "pbrt/integrators/surface_point.h"

namespace lacquer {
namespace {

class PathIntegrator final : public Integrator {
  public:
    /// @param shadowsThroughInterfaces  false: surfaces of the interface material cast shadows, as pbrt's
    /// "path" has it
    PathIntegrator(const IntegratorArgs& args, bool shadowsThroughInterfaces)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          regularize_(args.params.GetBool("regularize", false)),
          shadowsThroughInterfaces_(shadowsThroughInterfaces),
          footprint_(args.scene.Camera(), args.scene.Resolution(), args.footprintScale) {
        const std::string name =
            args.params.GetChoice("lightsampler", "bvh", Registry<LightSamplerKind>::Names());
        lightSampler_ = Registry<LightSamplerKind>::Find(name)(scene_.SampledLights());
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        SampledSpectrum L(0), beta(1);
        Ray ray = cameraRay.ray;
        Previous previous;
        float etaScale = 1;
        bool anyNonSpecular = false;
        SurfaceInteraction si;
        for (int depth = 0;;) {
            ++state.raysTraced;
            if (!scene_.Intersect(ray, Infinity, &si)) {
                L += beta * EscapedRadiance(ray, previous, lambda, state);
                break;
            }
            // Emission at the hit, weighted against having sampled that light.
            if (si.areaLight) L += beta * Emission(si, previous, lambda, state);

            const CameraRay* firstHit = depth == 0 ? &cameraRay : nullptr;
            const std::optional<Bsdf> bsdf = MakeBsdf(&si, firstHit, footprint_, lambda, state.arena);
            if (!bsdf) {
                // Where interfaces stop shadow rays, light behind one is found by scattered rays alone.
                if (!shadowsThroughInterfaces_) previous.specular = true;
                ray = SpawnRay(si, ray.d);
                continue;
            }
            if (depth == 0 && state.firstHit) state.firstHit->Record(si, *bsdf->bxdf, bsdf->wo);
            if (regularize_ && anyNonSpecular) bsdf->bxdf->Regularize();
            if (depth++ == maxDepth_) break;
            ++state.pathLengthSum;

            const BxDFContext context{.rng = &state.rng, .counters = &state.bxdf};
            if (IsNonSpecular(bsdf->Flags()))
                L += beta * DirectLight(si, *bsdf, context, lambda, sampler, state);

            // Continue the path by a draw from the BxDF.
            const float uLobe = sampler.Get1D();
            const std::optional<BxDFSample> sample = bsdf->Sample({uLobe, sampler.Get2D()}, context);
            if (!sample) break;
            beta *= sample->weight;
            if (!beta) break;
            previous = {LightReference(si), sample->IsSpecular(), sample->pdf, std::nullopt};
            if (!sample->pdfExact) previous.bsdf = bsdf;
            anyNonSpecular |= !previous.specular;
            if (sample->IsTransmission()) etaScale *= Sqr(sample->eta);
            ray = SpawnRay(si, sample->wi);

            // Russian roulette on the throughput, without the solid-angle compression of refraction.
            const float survival = beta.MaxComponent() * etaScale;
            if (depth > 1 && survival < 1) {
                if (sampler.Get1D() >= survival) break;
                beta /= survival;
            }
        }
        return L;
    }

  private:
    /// The vertex before the current ray, for the weights of emission that the ray finds.
    struct Previous {
        LightReference reference;
        bool specular = true;  ///< no light was sampled there (or it is the camera): emission counts fully
        float pdf = 0;         ///< of the direction [1/sr]
        /// Set where that pdf is not known: asked for one only if the ray meets a light. Then it is the same
        /// estimate that the light strategy is weighted with.
        std::optional<Bsdf> bsdf;
    };

    static float PdfOf(const Previous& previous, Vec3 wi, ThreadState& state) {
        if (!previous.bsdf) return previous.pdf;
        return previous.bsdf->Pdf(wi, {TransportMode::Radiance, Lobes::BothSides, &state.rng});
    }

    float EmissionWeight(const Light* light, const Previous& previous, Vec3 wi, const SurfaceInteraction* hit,
                         ThreadState& state) const {
        if (previous.specular) return 1;
        if (light->IsUniformInfinite()) return 1;
        const float pdfLight =
            lightSampler_->Pmf(previous.reference, light) * light->PdfLi(previous.reference, wi, hit);
        return PowerHeuristic(PdfOf(previous, wi, state), pdfLight);
    }

    SampledSpectrum Emission(const SurfaceInteraction& si, const Previous& previous,
                             const SampledWavelengths& lambda, ThreadState& state) const {
        const SampledSpectrum Le = si.areaLight->L(si.p, si.n, si.uv, si.wo, lambda);
        if (!Le) return Le;
        return Le * EmissionWeight(si.areaLight, previous, -si.wo, &si, state);
    }

    SampledSpectrum EscapedRadiance(const Ray& ray, const Previous& previous,
                                    const SampledWavelengths& lambda, ThreadState& state) const {
        SampledSpectrum sum(0);
        for (const Light* light : scene_.InfiniteLights()) {
            const SampledSpectrum Le = light->Le(ray, lambda);
            if (Le) sum += Le * EmissionWeight(light, previous, ray.d, nullptr, state);
        }
        return sum;
    }

    /// One light sample, weighted against the BxDF's density.
    SampledSpectrum DirectLight(const SurfaceInteraction& si, const Bsdf& bsdf, const BxDFContext& context,
                                const SampledWavelengths& lambda, Sampler& sampler,
                                ThreadState& state) const {
        const LightReference reference(si);
        const std::optional<SampledLight> chosen = lightSampler_->Sample(reference, sampler.Get1D());
        const Point2 uLight = sampler.Get2D();  // drawn in any case: dimensions must not shift
        if (!chosen) return SampledSpectrum(0);
        const std::optional<LightSample> ls = chosen->light->SampleLi(reference, uLight, lambda);
        if (!ls) return SampledSpectrum(0);

        // Where the density costs a draw of its own, it waits until light is known to arrive.
        BxDFContext withoutPdf = context;
        withoutPdf.needsPdf = false;
        const BxDFValue value = bsdf.Evaluate(ls->wi, withoutPdf);
        const SampledSpectrum f = value.f * AbsDot(ls->wi, si.shading.n);
        if (!f || !scene_.Visible(si, *ls, shadowsThroughInterfaces_, &state.shadowRays))
            return SampledSpectrum(0);
        const float pdfLight = chosen->p * ls->pdf;
        if (chosen->light->IsDelta()) return f * ls->L / pdfLight;
        const float pdf = value.pdf > 0 ? value.pdf : bsdf.Pdf(ls->wi, context);
        const float weight = PowerHeuristic(pdfLight, pdf);
        return f * ls->L * (weight / pdfLight);
    }

    const Scene& scene_;
    int maxDepth_;
    bool regularize_, shadowsThroughInterfaces_;
    FootprintEstimator footprint_;
    std::unique_ptr<LightSampler> lightSampler_;
};

std::unique_ptr<Integrator> CreatePath(const IntegratorArgs& args) {
    return std::make_unique<PathIntegrator>(args, false);
}
// Without media, volumetric path tracing is path tracing; only its shadow rays pass interfaces.
std::unique_ptr<Integrator> CreateVolPath(const IntegratorArgs& args) {
    return std::make_unique<PathIntegrator>(args, true);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "path", CreatePath);
LACQUER_REGISTER(IntegratorKind, "volpath", CreateVolPath);

}  // namespace lacquer
