#include "pbrt/integrators/subpath.h"

#include <fmt/format.h>

namespace lacquer {

ScatterDensities DensitiesOf(const Bsdf& bsdf, Vec3 wi, TransportMode mode, ScatterDensities known,
                             ThreadState& state) {
    if (known.reverse > 0 && known.forward > 0) return known;
    // An estimate may be 0 where the density is not. Weights could then be 0 / 0.
    constexpr float kLeast = 1e-4f;
    if (!(known.forward > 0)) known.forward = bsdf.Pdf(wi, {.mode = mode, .rng = &state.rng});
    const BxDFContext back{.mode = !mode, .rng = &state.rng};
    known.reverse = bsdf.bxdf->Pdf(bsdf.frame.ToLocal(wi), bsdf.wo, back);
    return {std::max(known.forward, kLeast), std::max(known.reverse, kLeast)};
}

void SubpathTracer::Extend(Subpath& path, Ray ray, SampledSpectrum beta, float pdfDirection,
                           TransportMode mode, size_t mostVertices, const CameraRay* cameraRay,
                           SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) const {
    mostVertices = std::min(mostVertices, Subpath::kMost);
    const float start = beta.MaxComponent();
    float etaScale = 1;
    bool anyNonSpecular = false;
    while (path.Size() < mostVertices) {
        PathVertex& previous = path[path.Size() - 1];
        PathVertex v;
        v.beta = beta;
        ++state.raysTraced;
        if (!scene.Intersect(ray, Infinity, &v.si)) {
            if (mode == TransportMode::Importance) return;
            v.kind = PathVertex::Kind::Light;
            v.isInfinite = true;
            v.toLight = ray.d;
            v.pdfForward = pdfDirection;
            path.Add(v);
            return;
        }
        const CameraRay* firstHit = path.Size() == 1 ? cameraRay : nullptr;
        const std::optional<Bsdf> bsdf = MakeBsdf(&v.si, firstHit, footprint, lambda, state.arena);
        if (!bsdf) {
            ray = SpawnRay(v.si, ray.d);
            continue;
        }
        if (previous.isInfinite && !IsLit(previous, v.si, lambda)) return;
        v.bsdf = *bsdf;
        if (firstHit && state.firstHit) state.firstHit->Record(v.si, *bsdf->bxdf, bsdf->wo);
        if (regularize && anyNonSpecular) bsdf->bxdf->Regularize();
        v.pdfForward = previous.ToArea(pdfDirection, v);
        PathVertex& here = path.Add(v);
        ++state.pathLengthSum;
        if (path.Size() == mostVertices) return;

        // Draw the next direction, and find how likely the way back is.
        const BxDFContext context{.mode = mode, .rng = &state.rng, .counters = &state.bxdf};
        const float uLobe = sampler.Get1D();
        const std::optional<BxDFSample> sample = bsdf->Sample({uLobe, sampler.Get2D()}, context);
        if (!sample) return;
        beta *= sample->weight;
        if (mode == TransportMode::Importance) beta *= ShadingNormalFactor(v.si, v.si.wo, sample->wi);
        if (!beta) return;
        here.isDelta = sample->IsSpecular();
        ScatterDensities pdf{sample->pdfExact ? sample->pdf : 0, sample->pdfExact ? sample->pdfReverse : 0};
        if (!here.isDelta) pdf = DensitiesOf(*bsdf, sample->wi, mode, pdf, state);
        previous.pdfReverse = here.ToArea(pdf.reverse, previous);
        pdfDirection = pdf.forward;
        anyNonSpecular |= !here.isDelta;
        if (sample->IsTransmission() && mode == TransportMode::Radiance) etaScale *= Sqr(sample->eta);
        ray = SpawnRay(v.si, sample->wi);

        // Russian roulette, which the weights ignore: they may be any function of the path.
        const float survival = beta.MaxComponent() * etaScale / start;
        if (path.Size() > 4 && survival < 1) {
            if (sampler.Get1D() >= survival) return;
            beta /= survival;
        }
    }
}

std::optional<LightStart> StartAtLight(const EmitterTable& emitters, float time,
                                       const SampledWavelengths& lambda, Sampler& sampler) {
    const float uLight = sampler.Get1D();
    const Point2 uPosition = sampler.Get2D(), uDirection = sampler.Get2D();
    const std::optional<SampledLight> chosen = emitters.Sample(uLight);
    if (!chosen || !(chosen->p > 0)) return std::nullopt;
    const std::optional<LightEmission> emitted = chosen->light->SampleLe(uPosition, uDirection, lambda);
    if (!emitted) return std::nullopt;

    const Light::Kind kind = chosen->light->GetKind();
    LightStart start;
    PathVertex& v = start.vertex;
    v.kind = PathVertex::Kind::Light;
    v.light = chosen->light;
    v.isInfinite = kind == Light::Kind::Infinite || kind == Light::Kind::DeltaDirection;
    v.toLight = -emitted->w;
    v.si.p = emitted->p;
    v.si.pError = emitted->pError;
    v.si.n = v.si.shading.n = emitted->n;
    v.si.uv = emitted->uv;
    v.si.time = time;
    v.beta = SampledSpectrum(1 / (chosen->p * emitted->pdfPosition));
    // Densities for weights come from one function, which all strategies ask.
    const EmissionDensity pdf = chosen->light->PdfLe(emitted->n, emitted->w);
    v.pdfForward = chosen->p * (v.isInfinite ? pdf.direction : pdf.position);
    v.pdfPlane = v.isInfinite ? pdf.position : 0;
    start.pdfDirection = pdf.direction;

    const bool hasNormal = emitted->n != Normal3(0);
    const float cosine = hasNormal ? AbsDot(emitted->n, emitted->w) : 1.f;
    start.beta = emitted->L * (cosine / (chosen->p * emitted->pdfPosition * emitted->pdfDirection));
    start.ray = {hasNormal ? OffsetRayOrigin(v.si.p, v.si.pError, v.si.n, emitted->w) : v.si.p, emitted->w,
                 time};
    return start;
}

bool IsLit(const PathVertex& start, const SurfaceInteraction& si, const SampledWavelengths& lambda) {
    if (!start.isInfinite || !start.light->IsInfinite()) return true;
    return bool(start.light->Le({si.p, start.toLight, si.time}, lambda));
}

void RequireImportance(const IntegratorArgs& args) {
    if (const std::string why = args.scene.Camera().WhyNoImportance(); !why.empty())
        throw SceneError(args.params.Loc(), fmt::format("{}: {}", args.params.Owner(), why));
}

std::optional<CameraArrival> ConnectToCamera(const Scene& scene, const PathVertex& v, Point2 uLens,
                                             const SampledWavelengths& lambda, ThreadState& state) {
    const std::optional<CameraConnection> c = scene.Camera().SampleWi(v.si.p, v.si.time, uLens);
    if (!c || !state.film->IsInSplatRange(c->pFilm)) return std::nullopt;
    SampledSpectrum L = v.beta * (c->importance / c->pdf);
    BxDFValue scattering;
    if (v.kind == PathVertex::Kind::Light) {
        // Only area lights can be seen in this way.
        if (v.light->GetKind() != Light::Kind::Area) return std::nullopt;
        L *= v.light->L(v.si.p, v.si.n, v.si.uv, c->wi, lambda) * AbsDot(v.si.n, c->wi);
    } else {
        if (!IsNonSpecular(v.bsdf.Flags())) return std::nullopt;
        const BxDFContext context{
            .mode = TransportMode::Importance, .rng = &state.rng, .needsPdf = false, .counters = &state.bxdf};
        scattering = v.bsdf.Evaluate(c->wi, context);
        L *= scattering.f * (ShadingNormalFactor(v.si, v.si.wo, c->wi) * AbsDot(c->wi, v.si.shading.n));
    }
    LightSample lens;
    lens.p = c->p;
    if (!L || !scene.Visible(v.si, lens, true, &state.shadowRays)) return std::nullopt;
    return CameraArrival{*c, L, scattering};
}

}  // namespace lacquer
