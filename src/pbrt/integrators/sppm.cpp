// Integrator "sppm": stochastic progressive photon mapping [Hachisuka and Jensen 2009]. An iteration traces
// photons from the lights; a path from the camera goes on through smooth glass and mirrors until it finds a
// surface with a diffuse lobe, takes the direct light there by next-event estimation (light sampler "bvh"),
// and all other light from the photons within a radius, which shrinks from one iteration to the next. Samples
// per pixel are iterations.
//
// Media scatter both kinds of paths. Photons are kept at surfaces alone: where a medium scatters, a path from
// the camera takes the direct light and goes on. Media that glow send out no photons: for their light alone,
// paths go on from where photons have all other.
//
//   "integer maxdepth"             5   scattering events of a path from the camera, and of one from a light
//   "integer photonsperiteration"  -1  paths from the lights; -1: as many as the image has pixels
//   "float radius"                 1   of the first iteration [m], > 0
//   "integer seed"                 the option's   of the photons
//
// The radius of an iteration depends on its number alone [Knaus and Zwicker 2011], where pbrt-v4 shrinks that
// of each pixel by the photons that it has found [Hachisuka et al. 2008]. Both rules converge, and reduce
// radii alike where photons keep coming: the square falls as iterations^(alpha - 1). With this one an
// iteration is a sample with a number, and the image is the mean of any set of them: it can be divided among
// machines, stopped, resumed and merged, with the same bits, and a pixel has no statistics but those of the
// film.
#include "pbrt/core/check.h"
#include "pbrt/integrators/medium_flight.h"
#include "pbrt/integrators/photon_pass.h"
#include "pbrt/integrators/substitutes.h"

namespace lacquer {
namespace {

class SppmIntegrator final : public Integrator {
  public:
    explicit SppmIntegrator(const IntegratorArgs& args)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          surroundings_(args),
          photons_(args, maxDepth_),
          lightSampler_(Registry<LightSamplerKind>::Find("bvh")(scene_.SampledLights())) {
        for (const Light* light : scene_.Lights()) anyHits_ |= !light->IsDelta();
        for (const auto& medium : scene_.Parts().media) anyGlows_ |= medium->IsEmissive();
    }
    bool SharesSamples() const override { return true; }
    bool RendersMedia() const override { return true; }
    std::unique_ptr<const SharedSample> ShareSample(const SharedSampleArgs& args) const override {
        return photons_.Trace(args);
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        LACQUER_CHECK(state.shared);
        const auto& pass = static_cast<const PhotonPass&>(*state.shared);
        lambda = pass.Wavelengths();
        Path path{.traced = TracedPath::FromCamera(surroundings_, cameraRay, maxDepth_, state),
                  .ray = cameraRay.ray,
                  .lambda = lambda,
                  .medium = scene_.CameraMedium()};
        while (FollowRay(&path, pass, sampler, state)) {
        }
        return path.L;
    }

  private:
    /// A path from the camera.
    struct Path {
        TracedPath traced;
        Ray ray;
        SampledWavelengths lambda;  ///< the caller's, until a dispersive event ends all but the first one
        SampledSpectrum L{0.f};
        SampledSpectrum beta{1.f};  ///< throughput over density at the first wavelength
        SpectralPdfs pdfs{};
        const Medium* medium = nullptr;  ///< around the ray; null: vacuum
        float etaScale = 1;              ///< undoes the solid-angle compression of refraction
        // Of the vertex before the ray:
        LightReference from{};
        float pdf = 0;               ///< of the ray's direction [1/sr]
        std::optional<Bsdf> bsdf{};  ///< where that pdf is not known
        bool isSpecular = true;      ///< no light was drawn there
        bool isLast = false;         ///< photons have all its light but what comes straight from the lights
        bool forGlow = false;     ///< what it finds of lights has been counted: it is after media that glow
        SurfaceInteraction si{};  ///< the vertex itself

        /// After a dispersive event the first wavelength stands for the others, which the caller keeps: all
        /// light of a sample is weighted alike.
        void Add(SampledSpectrum light) { L += lambda.SecondaryTerminated() ? OnlyFirst(light) : light; }
    };

    /// Follows the path's ray to what it meets next. False: the path ends.
    bool FollowRay(Path* path, const PhotonPass& pass, Sampler& sampler, ThreadState& state) const {
        SurfaceInteraction& si = path->si;
        const bool hit = path->traced.Intersect(path->ray, &si);
        if (path->medium) {
            const float tMax = hit ? Dot(si.p - path->ray.o, path->ray.d) : kMaxRayDistance;
            const MediumFlight flight = CrossMedium(path, tMax, sampler, state);
            if (flight.end == MediumFlight::End::Absorbed) return false;
            if (flight.end == MediumFlight::End::Scattered)
                return ScatterInMedium(path, flight.p, sampler, state) && SurvivesRoulette(path, sampler);
        }
        if (!hit) {
            if (path->forGlow) return false;
            for (const Light* light : scene_.InfiniteLights())
                if (const SampledSpectrum Le = light->Le(path->ray, path->lambda))
                    path->Add(path->beta * Le * EmissionWeight(*path, *light, nullptr, state));
            return false;
        }
        if (si.areaLight && !path->forGlow) {
            const SampledSpectrum Le = si.areaLight->L(si.p, si.n, si.uv, si.wo, path->lambda);
            if (Le) path->Add(path->beta * Le * EmissionWeight(*path, *si.areaLight, &si, state));
        }
        const bool isInterface = !si.material || si.material->IsInvisible();
        if (path->isLast && !isInterface && !GoesOnForGlow(path)) return false;
        Bsdf bsdf;
        switch (path->traced.Scatter(&si, path->lambda, &bsdf)) {
            case AtSurface::Ends:
                return false;
            case AtSurface::Passes:
                ContinueRay(path, path->ray.d);
                return true;
            case AtSurface::Scatters:
                break;
        }
        if (IsNonSpecular(bsdf.Flags()) && !path->forGlow) {
            AddDirectLight(path, sampler, state, [&](Vec3 wi) -> DirectScattering {
                const BxDFValue value = bsdf.Evaluate(wi, state.Context());
                return {value.f * AbsDot(wi, si.shading.n), SampledSpectrum(value.pdf)};
            });
            // Glossy surfaces see few of the photons by a narrow lobe, and much of what is reflected in them.
            path->isLast = Any(bsdf.Flags(), Lobes::Diffuse) || path->traced.Depth() == maxDepth_;
            AddPhotons(path, bsdf, pass, state);
        }
        return Scatter(path, bsdf, sampler, state) && SurvivesRoulette(path, sampler);
    }

    /// Past the last vertex that photons know of.
    bool GoesOnForGlow(Path* path) const {
        path->isLast = false;
        return path->forGlow = anyGlows_;
    }

    static MediumFlight CrossMedium(Path* path, float tMax, Sampler& sampler, ThreadState& state) {
        const MediumFlight flight =
            FlyThrough(*path->medium, path->ray, tMax, path->lambda, &path->beta, &path->pdfs, sampler,
                       state.rng, [&](SampledSpectrum light, SampledSpectrum pdfs) {
                           path->Add(light / MeanPdf(pdfs, path->lambda));
                       });
        path->traced.Cover(flight.covered);
        return flight;
    }

    /// Direct light at a point of a medium, and a new direction. False: the path ends.
    bool ScatterInMedium(Path* path, Point3 p, Sampler& sampler, ThreadState& state) const {
        if (path->isLast && !GoesOnForGlow(path)) return false;
        if (!path->traced.ScatterInMedium()) return false;
        const PhaseFunction& phase = path->medium->Phase(path->lambda, state.arena);
        const Vec3 wo = -path->ray.d;
        path->si = InMedium(p, path->ray);
        const auto scatter = [&](Vec3 wi) -> DirectScattering {
            const SpectralPhaseValue value = phase.EvaluateSpectral(wo, wi);
            return {value.p, value.pdf};
        };
        if (!path->forGlow) AddDirectLight(path, sampler, state, scatter);
        path->pdfs.StartEdge();
        const std::optional<DrawnDirection> drawn =
            SamplePhase(phase, wo, &path->beta, &path->pdfs, state.rng);
        if (!drawn) return false;
        path->isSpecular = false;
        path->from = LightReference(p);
        path->pdf = drawn->pdf;
        path->bsdf.reset();
        path->ray = {p, drawn->wi, path->ray.time};
        return bool(path->beta);
    }

    /// Weight of emission that the path's ray finds: over the mean density of the wavelengths, and against
    /// that of a light sample.
    float EmissionWeight(const Path& path, const Light& light, const SurfaceInteraction* hit,
                         ThreadState& state) const {
        const float pdfs = MeanPdf(path.pdfs.scattering, path.lambda);
        if (path.isSpecular || light.IsUniformInfinite()) return 1 / pdfs;
        const float pdf = path.bsdf ? path.bsdf->Pdf(path.ray.d, state.Context()) : path.pdf;
        const float pdfLight = lightSampler_->Pmf(path.from, &light) *
                               light.PdfLi(path.from, path.ray.d, hit) *
                               MeanPdf(path.pdfs.light, path.lambda);
        return PowerHeuristic(pdfs * pdf, pdfLight) / pdfs;
    }

    /// What a vertex scatters, the cosine included, and the density of scattering by wavelength [1/sr].
    struct DirectScattering {
        SampledSpectrum f, pdf;
    };
    /// A light sample at path->si. @param scatter  (wi): DirectScattering
    template <class Scattering>
    void AddDirectLight(Path* path, Sampler& sampler, ThreadState& state, const Scattering& scatter) const {
        const SurfaceInteraction& si = path->si;
        const LightReference from(si);
        const std::optional<SampledLight> chosen = lightSampler_->Sample(from, sampler.Get1D());
        const Point2 u = sampler.Get2D();
        if (!chosen) return;
        const std::optional<LightSample> ls = chosen->light->SampleLi(from, u, path->lambda);
        if (!ls) return;
        const DirectScattering value = scatter(ls->wi);
        if (!value.f) return;
        const ShadowRay shadow = TraceShadowRay(scene_, si, *ls, ls->wi, path->medium, path->lambda, state);
        if (!shadow.T) return;
        const float pdf =
            chosen->p * ls->pdf * MeanPdf(path->pdfs.scattering * shadow.pdfs.light, path->lambda);
        const float pdfScattered =
            MeanPdf(path->pdfs.scattering * shadow.pdfs.scattering, value.pdf, path->lambda);
        const float weight = chosen->light->IsDelta() ? 1.f : PowerHeuristic(pdf, pdfScattered);
        path->Add(path->beta * value.f * shadow.T * ls->L * (weight / pdf));
    }

    /// Light that more than one surface scatters: density of the flux over the disk within the radius, for
    /// surfaces are flat in the limit [Jensen 1996].
    static void AddPhotons(Path* path, const Bsdf& bsdf, const PhotonPass& pass, ThreadState& state) {
        const BxDFContext context{.rng = &state.rng, .needsPdf = false, .counters = &state.bxdf};
        SampledSpectrum sum(0);
        pass.Map().ForEachNear(path->si.p, [&](const Photon& photon) {
            if (path->isLast || photon.isHidden) sum += bsdf.Evaluate(photon.wi, context).f * photon.flux;
        });
        const float area = Pi * Sqr(pass.Map().Radius());
        if (sum) path->Add(path->beta * sum / (area * MeanPdf(path->pdfs.scattering, path->lambda)));
    }

    /// Sets the ray that leaves a surface. False: the path ends.
    bool Scatter(Path* path, const Bsdf& bsdf, Sampler& sampler, ThreadState& state) const {
        const float uLobe = sampler.Get1D();
        const std::optional<BxDFSample> sample = bsdf.Sample({uLobe, sampler.Get2D()}, state.Context());
        if (!sample) return false;
        path->isSpecular = sample->IsSpecular();
        // Photons know no specular lobes: where one was drawn, the path goes on.
        path->isLast &= !path->isSpecular;
        if (path->isLast && !anyHits_ && !anyGlows_) return false;
        path->beta *= sample->weight;
        if (!path->beta) return false;
        path->from = LightReference(path->si);
        path->pdf = sample->pdf;
        path->bsdf.reset();
        if (!sample->pdfExact) path->bsdf = bsdf;
        if (sample->IsTransmission()) path->etaScale *= Sqr(sample->eta);
        path->pdfs.StartEdge();
        ContinueRay(path, sample->wi);
        return true;
    }
    static void ContinueRay(Path* path, Vec3 direction) {
        path->medium = path->si.MediumToward(direction, path->medium);
        path->ray = SpawnRay(path->si, direction);
    }

    static bool SurvivesRoulette(Path* path, Sampler& sampler) {
        const float survival = std::sqrt(path->beta.MaxComponent() * path->etaScale /
                                         MeanPdf(path->pdfs.scattering, path->lambda));
        if (path->traced.Depth() <= 1 || survival >= 1) return true;
        if (sampler.Get1D() >= survival) return false;
        path->beta /= survival;
        return true;
    }

    const Scene& scene_;
    int maxDepth_;
    PathSurroundings surroundings_;
    PhotonTracer photons_;
    std::unique_ptr<LightSampler> lightSampler_;
    bool anyHits_ = false;   ///< there is a light that rays can hit
    bool anyGlows_ = false;  ///< there is a medium that emits
};

std::unique_ptr<Integrator> CreateSppm(const IntegratorArgs& args) {
    const std::string why = WhyNoLightPaths(args.scene);
    if (!why.empty()) {
        for (const char* name : {"photonsperiteration", "seed"}) args.params.Ignore("integer", name);
        args.params.Ignore("float", "radius");
        return VolPathInstead(args, "integrator \"sppm\" " + why);
    }
    return std::make_unique<SppmIntegrator>(args);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "sppm", CreateSppm,
                 {.otherImage = "blurs light by a radius that shrinks with the number of samples"});

}  // namespace lacquer
