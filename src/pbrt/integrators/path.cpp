// Integrators "path" and "volpath": unidirectional path tracing with next-event estimation and multiple
// importance sampling [Veach 1997], through surfaces alone ("path") or through media as well ("volpath").
//
//   "integer maxdepth"     5      scattering events of a path after which it ends
//   "bool regularize"      false  widens narrow lobes after the first diffuse or glossy event of a path
//   "string lightsampler"  bvh    "bvh", "power", "uniform" or "exhaustive"
//   "bool guiding"         false  directions are drawn by what the first paths have found as well
#include "pbrt/film/pass_recorder.h"
#include "pbrt/integrators/guided_sampling.h"
#include "pbrt/integrators/medium_flight.h"
#include "pbrt/integrators/shadow_ray.h"
#include "pbrt/integrators/stack_split.h"
#include "pbrt/integrators/subsurface.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {
namespace {

/// @tparam kVolumes  false: media are vacuum, and nothing of them costs time
template <bool kVolumes>
class PathIntegrator final : public Integrator {
  public:
    /// @param shadowsThroughInterfaces  false: surfaces of the interface material cast shadows, as pbrt's
    /// "path" has it
    PathIntegrator(const IntegratorArgs& args, bool shadowsThroughInterfaces)
        : scene_(args.scene),
          maxDepth_(args.params.GetIntInRange("maxdepth", 5, 0, 1 << 20)),
          regularize_(args.params.GetBool("regularize", false)),
          shadowsThroughInterfaces_(shadowsThroughInterfaces),
          usesGuide_(args.params.GetBool("guiding", false)),
          surroundings_(args) {
        const std::string name =
            args.params.GetChoice("lightsampler", "bvh", Registry<LightSamplerKind>::Names());
        lightSampler_ = Registry<LightSamplerKind>::Find(name)(scene_.SampledLights());
    }

    SampledSpectrum Li(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const override {
        if (!kVolumes) return Trace(cameraRay, lambda, sampler, state);
        // Light that was found before a dispersive event counts at all wavelengths: their weights belong
        // together.
        SampledWavelengths followed = lambda;
        return Trace(cameraRay, followed, sampler, state);
    }

    bool RendersMedia() const override { return kVolumes; }
    bool UsesGuide() const override { return usesGuide_; }
    bool TellsPasses() const override { return true; }

  private:
    SampledSpectrum Trace(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                          ThreadState& state) const {
        if (!state.guide || !state.guide->IsLearning())
            return Trace(cameraRay, lambda, sampler, state, nullptr);
        GuidedPath vertices;
        const SampledSpectrum L = Trace(cameraRay, lambda, sampler, state, &vertices);
        state.guide->Learn(vertices, L.Average());
        return L;
    }
    /// @param vertices  takes those where a guide could draw; null: nobody asks
    SampledSpectrum Trace(const CameraRay& cameraRay, SampledWavelengths& lambda, Sampler& sampler,
                          ThreadState& state, GuidedPath* vertices) const {
        Path path{.traced = TracedPath::FromCamera(surroundings_, cameraRay, maxDepth_, state),
                  .ray = cameraRay.ray};
        if (kVolumes) path.medium = scene_.CameraMedium();
        path.disperses = !lambda.SecondaryTerminated();
        path.passes = PathPasses(state.passes);
        path.guide = state.guide;
        path.vertices = vertices;
        SurfaceInteraction si;
        for (;;) {
            const Flight flight = FollowRay(&path, &si, lambda, sampler, state);
            if (flight == Flight::Ended) break;
            if (flight == Flight::Scattered && !SurvivesRoulette(&path, lambda, sampler)) break;
        }
        return path.L;
    }

    /// The vertex before the current ray, for the weights of emission that the ray finds.
    struct Previous {
        LightReference reference;
        bool specular = true;  ///< no light was sampled there (or it is the camera): emission counts fully
        float pdf = 0;         ///< of the direction [1/sr]
        /// Set where that pdf is not known: asked for one only if the ray meets a light. Then it is the same
        /// estimate that the light strategy is weighted with.
        std::optional<Bsdf> bsdf;
        GuidedDensity guided;  ///< of which that BxDF is a part

        /// In place: copies of what was just written, in wider pieces, stall.
        /// @param at  whatever a LightReference is made from
        template <class Place>
        void Set(const Place& at, bool isSpecular, float density) {
            std::construct_at(&reference, at);
            specular = isSpecular;
            pdf = density;
            bsdf.reset();
            guided = {};
        }
    };
    struct Path {
        TracedPath traced;
        Ray ray;
        SampledSpectrum L{0.f};
        SampledSpectrum beta{1.f};  ///< throughput over density at the first wavelength
        Previous previous{};
        float etaScale = 1;  ///< undoes the solid-angle compression of refraction
        bool anyNonSpecular = false;
        const Medium* medium = nullptr;  ///< around the ray; null: vacuum
        SpectralPdfs pdfs{};
        bool disperses = true;  ///< false: the caller's wavelengths were terminated before the path began
        PathPasses passes{};
        const PathGuide* guide = nullptr;  ///< null: scattering alone gives directions
        GuidedPath* vertices = nullptr;    ///< while the guide learns
        GuidedDensity guided{};            ///< of the vertex where the path is
        /// Densities of what was drawn over those of scattering: roulette does not hold it against a path
        /// that it goes where the light is.
        float guidedScale = 1;

        /// Light as it counts: with volumes the caller keeps all its wavelengths, and after a dispersive
        /// event the first one stands for the others.
        SampledSpectrum Counted(SampledSpectrum light, const SampledWavelengths& lambda) const {
            return kVolumes && disperses && lambda.SecondaryTerminated() ? OnlyFirst(light) : light;
        }
        /// Adds light. @param from  a light or a medium
        template <class Emitter>
        void Add(SampledSpectrum light, const Emitter& from, const SampledWavelengths& lambda) {
            light = Counted(light, lambda);
            L += light;
            if (passes) passes.Add(SourceOf(from), from.Group(), light);
        }
    };
    static PathSource SourceOf(const Light& light) {
        return light.IsInfinite() ? PathSource::Background : PathSource::Light;
    }
    static PathSource SourceOf(const Medium&) { return PathSource::Medium; }
    enum class Flight { Passed, Scattered, Ended };

    /// Follows the path's ray to what it meets next: adds emission and direct light there, and sets the ray
    /// that leaves. @param si  where the path is, if that is on a surface
    Flight FollowRay(Path* path, SurfaceInteraction* si, SampledWavelengths& lambda, Sampler& sampler,
                     ThreadState& state) const {
        const bool hit = path->traced.Intersect(path->ray, si);
        if (kVolumes && path->medium) {
            const float tMax = hit ? Dot(si->p - path->ray.o, path->ray.d) : kMaxRayDistance;
            const Flight flight = CrossMedium(path, tMax, lambda, sampler, state);
            if (flight != Flight::Passed) return flight;
        }
        if (!hit) {
            AddEscapedRadiance(path, lambda, state);
            return Flight::Ended;
        }
        // Emission at the hit, weighted against having sampled that light.
        if (si->areaLight) AddEmission(path, *si, lambda, state);

        Bsdf bsdf;
        switch (path->traced.Scatter(si, lambda, &bsdf)) {
            case AtSurface::Ends:
                return Flight::Ended;
            case AtSurface::Passes:
                // Where interfaces stop shadow rays, light behind one is found by scattered rays alone.
                if (!shadowsThroughInterfaces_) path->previous.specular = true;
                ContinueRay(path, *si, path->ray.d);
                return Flight::Passed;
            case AtSurface::Scatters:
                break;
        }
        if (regularize_ && path->anyNonSpecular) bsdf.bxdf->Regularize();
        return ScatterAtSurface(path, *si, bsdf, lambda, sampler, state) ? Flight::Scattered : Flight::Ended;
    }

    /// Direct light at a surface, and a new direction by a draw from its BxDF. False: the path ends.
    bool ScatterAtSurface(Path* path, const SurfaceInteraction& si, const Bsdf& bsdf,
                          const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) const {
        const BxDFContext context = state.Context();
        path->guided = GuidedAt(*path, si, bsdf);
        if (IsNonSpecular(bsdf.Flags())) AddDirectLight(path, si, bsdf, context, lambda, sampler, state);
        const float uLobe = sampler.Get1D();
        const BxDFRandom u{uLobe, sampler.Get2D()};
        const std::optional<BxDFSample> sample =
            path->guided ? SampleGuided(path, si, bsdf, u, context) : bsdf.Sample(u, context);
        if (!sample) return false;
        path->beta *= sample->weight;
        if (!path->beta) return false;
        path->previous.Set(si, sample->IsSpecular(), sample->pdf);
        if (!sample->pdfExact) {
            path->previous.bsdf = bsdf;
            path->previous.guided = path->guided;
        }
        path->anyNonSpecular |= !path->previous.specular;
        const bool isSubsurface = kVolumes && sample->IsTransmission() && bsdf.material->HasSubsurface();
        if (path->passes) MeetSurface(path, si, bsdf, *sample, isSubsurface);
        if (SplitsStack(*path, bsdf))
            path->passes.Recorder().FollowLayered(SharesOf(*sample, si, bsdf, path->passes.Random()));
        if (isSubsurface)
            return ScatterBelowSurface(path, si, *bsdf.material, context, lambda, sampler, state);
        if (sample->IsTransmission()) path->etaScale *= Sqr(sample->eta);
        if (kVolumes) path->pdfs.StartEdge();
        ContinueRay(path, si, sample->wi);
        return true;
    }

    /// What a surface draws directions by. Empty: by its BxDF alone, as below a surface and where passes ask
    /// for the draws of a stack.
    static GuidedDensity GuidedAt(const Path& path, const SurfaceInteraction& si, const Bsdf& bsdf) {
        if (!path.guide || !IsNonSpecular(bsdf.Flags()) || SplitsStack(path, bsdf)) return {};
        if (kVolumes && bsdf.material->HasSubsurface()) return {};
        const bool isDiffuse = !Any(bsdf.Flags(), Lobes::Glossy | Lobes::Specular);
        return path.guide->At(si.p, FacingOf(si, bsdf), isDiffuse ? GuidedKind::Diffuse : GuidedKind::Glossy);
    }
    [[gnu::noinline]] static std::optional<BxDFSample> SampleGuided(Path* path, const SurfaceInteraction& si,
                                                                    const Bsdf& bsdf, const BxDFRandom& u,
                                                                    const BxDFContext& context) {
        GuidedVertex vertex;
        const std::optional<BxDFSample> sample =
            lacquer::SampleGuided(path->guided, si, bsdf, u, context, &vertex);
        if (sample) AddVertex(path, sample->weight, &vertex);
        return sample;
    }
    static void AddVertex(Path* path, const SampledSpectrum& weight, GuidedVertex* vertex) {
        if (vertex->scattering > 0)
            path->guidedScale *= vertex->density.Of(vertex->scattering, vertex->learned) / vertex->scattering;
        if (!path->vertices) return;
        vertex->throughputBefore = double(path->beta.Average());
        vertex->throughput = double((path->beta * weight).Average());
        vertex->found = double(path->L.Average());
        path->vertices->Add(*vertex);
    }

    static void ContinueRay(Path* path, const SurfaceInteraction& si, Vec3 direction) {
        if (kVolumes) path->medium = si.MediumToward(direction, path->medium);
        path->ray = SpawnRay(si, direction);
    }

    /// Russian roulette on the throughput, without the solid-angle compression of refraction. By its root and
    /// not by itself: paths of little throughput that survive take time, but those that do not are noise of
    /// what they would have found. docs/performance.md has what other rules gave.
    static bool SurvivesRoulette(Path* path, const SampledWavelengths& lambda, Sampler& sampler) {
        float throughput = path->beta.MaxComponent() * path->etaScale * path->guidedScale;
        if (kVolumes) throughput /= MeanPdf(path->pdfs.scattering, lambda);
        if (path->traced.Depth() > 1 && throughput < 1) {
            const float survival = std::sqrt(throughput);
            if (sampler.Get1D() >= survival) return false;
            path->beta /= survival;
        }
        return true;
    }

    static float PdfOf(const Previous& previous, Vec3 wi, ThreadState& state) {
        if (!previous.bsdf) return previous.pdf;
        return previous.guided.At(previous.bsdf->Pdf(wi, state.Context()), wi);
    }

    /// What emission that the path's ray finds counts for: over the mean density of the wavelengths, and
    /// against a light sample.
    float EmissionWeight(const Light* light, const Path& path, const SurfaceInteraction* hit,
                         const SampledWavelengths& lambda, ThreadState& state) const {
        const float pdfScattering = kVolumes ? MeanPdf(path.pdfs.scattering, lambda) : 1;
        if (path.previous.specular || light->IsUniformInfinite()) return 1 / pdfScattering;
        const LightReference& reference = path.previous.reference;
        const Vec3 wi = path.ray.d;
        const float pdfLight = lightSampler_->Pmf(reference, light) * light->PdfLi(reference, wi, hit) *
                               (kVolumes ? MeanPdf(path.pdfs.light, lambda) : 1);
        return PowerHeuristic(pdfScattering * PdfOf(path.previous, wi, state), pdfLight) / pdfScattering;
    }

    void AddEmission(Path* path, const SurfaceInteraction& si, const SampledWavelengths& lambda,
                     ThreadState& state) const {
        const SampledSpectrum Le = si.areaLight->L(si.p, si.n, si.uv, si.wo, lambda);
        if (!Le) return;
        path->Add(path->beta * (Le * EmissionWeight(si.areaLight, *path, &si, lambda, state)), *si.areaLight,
                  lambda);
    }

    void AddEscapedRadiance(Path* path, const SampledWavelengths& lambda, ThreadState& state) const {
        for (const Light* light : scene_.InfiniteLights()) {
            const SampledSpectrum Le = light->Le(path->ray, lambda);
            if (Le)
                path->Add(path->beta * (Le * EmissionWeight(light, *path, nullptr, lambda, state)), *light,
                          lambda);
        }
    }

    /// A light sample as a vertex draws it; empty where no light was chosen or none arrives.
    struct ChosenLightSample {
        std::optional<LightSample> sample;
        float p = 0;  ///< probability of the light
        const Light* light = nullptr;

        /// Of light and direction; 1/sr but for delta lights.
        float Pdf() const { return p * sample->pdf; }
    };
    /// Takes the same numbers from the sampler in any case: dimensions must not shift.
    ChosenLightSample SampleLight(const LightReference& reference, const SampledWavelengths& lambda,
                                  Sampler& sampler) const {
        const std::optional<SampledLight> chosen = lightSampler_->Sample(reference, sampler.Get1D());
        const Point2 uLight = sampler.Get2D();
        if (!chosen) return {};
        return {chosen->light->SampleLi(reference, uLight, lambda), chosen->p, chosen->light};
    }

    /// What arrives from a light sample where it scatters. Densities as in SpectralPdfs: of the whole path,
    /// over that at the first wavelength.
    struct ArrivingLight {
        SampledSpectrum L{0.f};
        float pdf = 0;  ///< of the path and the light sample, the mean over the wavelengths
        SampledSpectrum pdfsScattering{
            1.f};  ///< of the path by scattering, but for the direction to the light

        explicit operator bool() const { return bool(L); }
    };
    /// False where a surface scatters no light from there, by its side alone.
    static bool ScattersFrom(const Bsdf& bsdf, Vec3 wi) {
        if (SameHemisphere(bsdf.wo, bsdf.frame.ToLocal(wi))) return Any(bsdf.Flags(), Lobes::Reflection);
        // What is below a surface scatters: no light comes straight through it.
        return Any(bsdf.Flags(), Lobes::Transmission) && !(kVolumes && bsdf.material->HasSubsurface());
    }
    /// Follows a shadow ray. What scatters is asked after it: the values of most surfaces are zero in few
    /// directions of their sides, and many directions are in shadow.
    /// @param medium  around the point, on the side of the light
    ArrivingLight Arrive(const Path& path, const LightReference& reference, const ChosenLightSample& light,
                         const Medium* medium, const SampledWavelengths& lambda, ThreadState& state) const {
        const ShadowRay shadow =
            TraceShadowRay(scene_, reference, *light.sample, path.ray.time, medium, lambda, state);
        if (!shadow.T) return {};
        return {shadow.T * light.sample->L,
                MeanPdf(path.pdfs.scattering * shadow.pdfs.light, lambda) * light.Pdf(),
                path.pdfs.scattering * shadow.pdfs.scattering};
    }
    ArrivingLight Arrive(const Path& path, const SurfaceInteraction& si, const Bsdf& bsdf,
                         const ChosenLightSample& light, const SampledWavelengths& lambda,
                         ThreadState& state) const {
        const LightSample& ls = *light.sample;
        if (!ScattersFrom(bsdf, ls.wi)) return {};
        if (kVolumes)
            return Arrive(path, LightReference(si), light, si.MediumToward(ls.wi, path.medium), lambda,
                          state);
        if (!scene_.Visible(si, ls, shadowsThroughInterfaces_, state.rays)) return {};
        return {ls.L, light.Pdf()};
    }
    /// MeanPdf() with the direction by scattering, which costs nothing without volumes. @param drawn  its
    /// density
    static float PdfByScattering(const ArrivingLight& arriving, float drawn,
                                 const SampledWavelengths& lambda) {
        return kVolumes ? MeanPdf(arriving.pdfsScattering, drawn, lambda) : drawn;
    }
    static float PdfByScattering(const ArrivingLight& arriving, SampledSpectrum drawn,
                                 const SampledWavelengths& lambda) {
        return MeanPdf(arriving.pdfsScattering, drawn, lambda);
    }
    /// What arriving light counts for: over its density, and against scattering into its direction, whose
    /// density `pdfScattered()` gives.
    template <class Pdf>
    static float LightWeight(const ArrivingLight& arriving, const Light& light,
                             const SampledWavelengths& lambda, const Pdf& pdfScattered) {
        if (light.IsDelta()) return 1 / arriving.pdf;
        return PowerHeuristic(arriving.pdf, PdfByScattering(arriving, pdfScattered(), lambda)) / arriving.pdf;
    }

    void AddDirectLight(Path* path, const SurfaceInteraction& si, const Bsdf& bsdf,
                        const BxDFContext& context, const SampledWavelengths& lambda, Sampler& sampler,
                        ThreadState& state) const {
        const ChosenLightSample light = SampleLight(LightReference(si), lambda, sampler);
        if (!light.sample) return;
        const ArrivingLight arriving = Arrive(*path, si, bsdf, light, lambda, state);
        if (!arriving) return;
        std::optional<StackSplit> split;
        if (SplitsStack(*path, bsdf)) split.emplace(state.rng, state.dimensions);
        const BxDFValue value = ValueFor(light, bsdf, context);
        const SampledSpectrum L = Scattered(*path, si, bsdf, light, arriving, value, context, lambda);
        AddScattered(path, path->beta * L, value.f, *light.light, light.sample->wi, bsdf, lambda);
        if (split) AddSplit(*split, *path, si, bsdf, light, arriving, context, lambda, state, L, value.f);
    }
    /// Direct light of a stack, for the passes of its parts.
    /// @param L, f  scattered light, and the BxDF's value that it was found with
    [[gnu::noinline]] void AddSplit(const StackSplit& split, const Path& path, const SurfaceInteraction& si,
                                    const Bsdf& bsdf, const ChosenLightSample& light,
                                    const ArrivingLight& arriving, const BxDFContext& context,
                                    const SampledWavelengths& lambda, ThreadState& state, SampledSpectrum L,
                                    SampledSpectrum f) const {
        const LayeredParts parts = split.Of(bsdf, light.sample->wi, f);
        if (!f) {
            // Nothing was found together, but perhaps of the parts, each of which has to be right in the
            // mean.
            f = parts[size_t(LayeredPart::Surface)] + parts[size_t(LayeredPart::Single)];
            if (!f) return;
            const StateKeeper keeper(&state);
            BxDFValue value;
            value.f = f;
            L = Scattered(path, si, bsdf, light, arriving, value, context, lambda);
        }
        path.passes.Recorder().AddLayered(Times(parts, SafeDivide(path.Counted(path.beta * L, lambda), f)));
    }
    /// Adds light that a surface scatters once more. @param f  of the BxDF
    static void AddScattered(Path* path, SampledSpectrum light, SampledSpectrum f, const Light& from, Vec3 wi,
                             const Bsdf& bsdf, const SampledWavelengths& lambda) {
        light = path->Counted(light, lambda);
        path->L += light;
        if (!path->passes || !light) return;
        const bool isTransmission = !SameHemisphere(bsdf.wo, bsdf.frame.ToLocal(wi));
        const PathSource source = SourceOf(from);
        const auto add = [&](Lobes kind, SampledSpectrum part) {
            path->passes.AddAfter(EventOf(kind, isTransmission), source, from.Group(), part);
        };
        if (!HasBothKinds(bsdf.Flags())) {
            add(bsdf.Flags(), light);
        } else {
            const SampledSpectrum glossy = light * SafeDivide(GlossyPart(*path, bsdf, wi), f);
            add(Lobes::Glossy, glossy);
            add(Lobes::Diffuse, light - glossy);
        }
    }
    static SampledSpectrum GlossyPart(const Path& path, const Bsdf& bsdf, Vec3 wi) {
        const BxDFContext context{
            .sides = Lobes::BothSides | Lobes::Glossy, .rng = &path.passes.Random(), .needsPdf = false};
        return bsdf.Evaluate(wi, context).f;
    }
    /// True at a stack that the camera sees, where its parts are asked for.
    static bool SplitsStack(const Path& path, const Bsdf& bsdf) {
        return path.passes && path.traced.Depth() == 1 && path.passes.Recorder().WantsLayeredParts() &&
               bsdf.bxdf->CountsVertices();
    }
    /// Tells the passes what a draw from a BxDF is.
    static void MeetSurface(Path* path, const SurfaceInteraction& si, const Bsdf& bsdf,
                            const BxDFSample& sample, bool isSubsurface) {
        const bool isWhole = !sample.IsSpecular() && Any(sample.lobe, Lobes::Diffuse) && sample.pdf > 0;
        if (isSubsurface) {
            path->passes.Meet(PathEvent::DiffuseTransmission);
        } else if (isWhole && HasBothKinds(bsdf.Flags())) {
            // The weight is that of both kinds together.
            const SampledSpectrum f = sample.weight * (sample.pdf / AbsDot(sample.wi, si.shading.n));
            path->passes.MeetEither(EventOf(Lobes::Glossy, sample.IsTransmission()),
                                    EventOf(Lobes::Diffuse, sample.IsTransmission()),
                                    SafeDivide(GlossyPart(*path, bsdf, sample.wi), f));
        } else {
            path->passes.Meet(EventOf(bsdf.Flags(), sample));
        }
    }
    /// Where the density costs a draw of its own, it waits until it is known that light is scattered.
    static BxDFValue ValueFor(const ChosenLightSample& light, const Bsdf& bsdf, BxDFContext context) {
        context.needsPdf = false;
        return bsdf.Evaluate(light.sample->wi, context);
    }
    /// Arriving light, scattered by a surface. @param value  of its BxDF
    SampledSpectrum Scattered(const Path& path, const SurfaceInteraction& si, const Bsdf& bsdf,
                              const ChosenLightSample& light, const ArrivingLight& arriving,
                              const BxDFValue& value, const BxDFContext& context,
                              const SampledWavelengths& lambda) const {
        const Vec3 wi = light.sample->wi;
        const SampledSpectrum f = value.f * AbsDot(wi, si.shading.n);
        if (!f) return f;
        const auto pdfScattered = [&] {
            return path.guided.At(value.pdf > 0 ? value.pdf : bsdf.Pdf(wi, context), wi);
        };
        return f * arriving.L * LightWeight(arriving, *light.light, lambda, pdfScattered);
    }

    /// Moves a path that refracted into a surface to where the light leaves again: direct light there, and a
    /// new direction. False: the path ends. The refraction at the entry and that at the exit cancel in
    /// etaScale.
    bool ScatterBelowSurface(Path* path, const SurfaceInteraction& entry, const Material& material,
                             const BxDFContext& context, const SampledWavelengths& lambda, Sampler& sampler,
                             ThreadState& state) const {
        const BSSRDF* bssrdf = material.MakeBSSRDF(TextureContext(entry), lambda, state.arena);
        if (!bssrdf) return false;
        const std::optional<SubsurfaceExit> exit =
            SampleSubsurfaceExit(path->traced, entry, material, *bssrdf, sampler, state.arena);
        if (!exit) return false;
        path->beta *= exit->Sp / exit->pdf[0];
        path->pdfs.scattering *= exit->pdf / exit->pdf[0];
        path->pdfs.StartEdge();
        path->guided = {};
        // No event of its own: what is below the surface was one.
        const ChosenLightSample light = SampleLight(LightReference(exit->si), lambda, sampler);
        if (light.sample)
            if (const ArrivingLight arriving = Arrive(*path, exit->si, exit->bsdf, light, lambda, state))
                path->Add(path->beta * Scattered(*path, exit->si, exit->bsdf, light, arriving,
                                                 ValueFor(light, exit->bsdf, context), context, lambda),
                          *light.light, lambda);

        const float uLobe = sampler.Get1D();
        const std::optional<BxDFSample> sample = exit->bsdf.Sample({uLobe, sampler.Get2D()}, context);
        if (!sample) return false;
        path->beta *= sample->weight;
        path->previous.Set(exit->si, false, sample->pdf);
        path->anyNonSpecular = true;
        ContinueRay(path, exit->si, sample->wi);
        return bool(path->beta);
    }

    /// Follows the ray through its medium up to tMax: adds emission, and scatters or ends it.
    Flight CrossMedium(Path* path, float tMax, SampledWavelengths& lambda, Sampler& sampler,
                       ThreadState& state) const {
        const Medium& medium = *path->medium;
        const MediumFlight flight =
            FlyThrough(medium, path->ray, tMax, lambda, &path->beta, &path->pdfs, sampler, state.rng,
                       [&](SampledSpectrum light, SampledSpectrum pdfs) {
                           path->Add(light / MeanPdf(pdfs, lambda), medium, lambda);
                       });
        path->traced.Cover(flight.covered);
        switch (flight.end) {
            case MediumFlight::End::Crossed:
                return Flight::Passed;
            case MediumFlight::End::Absorbed:
                return Flight::Ended;
            case MediumFlight::End::Scattered:
                break;
        }
        return Scatter(path, medium.Phase(lambda, state.arena), flight.p, lambda, sampler, state);
    }

    /// Arriving light, scattered at a point of a medium.
    static void AddDirectLight(Path* path, const PhaseFunction& phase, Vec3 wo, const GuidedDensity& guided,
                               const ChosenLightSample& light, const ArrivingLight& arriving,
                               const SampledWavelengths& lambda) {
        if (!arriving) return;
        const Vec3 wi = light.sample->wi;
        const auto add = [&](auto phaseValue, auto pdf) {
            const float weight =
                LightWeight(arriving, *light.light, lambda, [&] { return guided.At(pdf, wi); });
            const SampledSpectrum L = path->Counted(path->beta * phaseValue * arriving.L * weight, lambda);
            path->L += L;
            path->passes.AddAfter(PathEvent::Volume, SourceOf(*light.light), light.light->Group(), L);
        };
        if (phase.IsChromatic()) {
            const SpectralPhaseValue value = phase.EvaluateSpectral(wo, wi);
            if (value.p) add(value.p, value.pdf);
        } else if (const PhaseValue value = phase.Evaluate(wo, wi); value.p > 0) {
            add(value.p, value.pdf);
        }
    }
    /// Direct light at a point of a medium, and a new direction.
    Flight Scatter(Path* path, const PhaseFunction& phase, Point3 p, const SampledWavelengths& lambda,
                   Sampler& sampler, ThreadState& state) const {
        if (!path->traced.ScatterInMedium()) return Flight::Ended;
        const LightReference reference(p);
        const Vec3 wo = -path->ray.d;
        const GuidedDensity guided =
            path->guide ? path->guide->At(p, GuidedFacing::Volume, GuidedKind::Volume) : GuidedDensity();
        if (const ChosenLightSample light = SampleLight(reference, lambda, sampler); light.sample)
            AddDirectLight(path, phase, wo, guided, light,
                           Arrive(*path, reference, light, path->medium, lambda, state), lambda);
        path->passes.Meet(PathEvent::Volume);
        path->anyNonSpecular = true;
        path->pdfs.StartEdge();
        const std::optional<DrawnDirection> drawn =
            guided ? SampleGuided(path, phase, wo, guided, state)
                   : SamplePhase(phase, wo, &path->beta, &path->pdfs, state.rng);
        if (!drawn) return Flight::Ended;
        path->previous.Set(reference, false, drawn->pdf);
        path->ray = {p, drawn->wi, path->ray.time};
        return Flight::Scattered;
    }

    /// SamplePhase() from its mixture with what was learned.
    [[gnu::noinline]] static std::optional<DrawnDirection> SampleGuided(Path* path,
                                                                        const PhaseFunction& phase, Vec3 wo,
                                                                        const GuidedDensity& guided,
                                                                        ThreadState& state) {
        GuidedVertex vertex;
        const std::optional<GuidedPhaseSample> sample =
            lacquer::SampleGuided(guided, phase, wo, &state.rng, &vertex);
        if (!sample) return {};
        AddVertex(path, sample->weight, &vertex);
        path->beta *= sample->weight;
        path->pdfs.scattering *= sample->pdf / sample->pdf[0];
        return DrawnDirection{sample->wi, sample->pdf[0]};
    }

    const Scene& scene_;
    int maxDepth_;
    bool regularize_, shadowsThroughInterfaces_, usesGuide_;
    PathSurroundings surroundings_;
    std::unique_ptr<LightSampler> lightSampler_;
};

std::unique_ptr<Integrator> CreatePath(const IntegratorArgs& args) {
    return std::make_unique<PathIntegrator<false>>(args, false);
}
// Without media, volumetric path tracing is path tracing; only its shadow rays pass interfaces.
std::unique_ptr<Integrator> CreateVolPath(const IntegratorArgs& args) {
    if (args.scene.HasMedia() || args.scene.HasSubsurface())
        return std::make_unique<PathIntegrator<true>>(args, true);
    return std::make_unique<PathIntegrator<false>>(args, true);
}

}  // namespace

LACQUER_REGISTER(IntegratorKind, "path", CreatePath,
                 {.shadowsOfInterfaces = true, .takesLightSampler = true});
LACQUER_REGISTER(IntegratorKind, "volpath", CreateVolPath,
                 {.rendersSubsurface = true, .takesLightSampler = true});

}  // namespace lacquer
