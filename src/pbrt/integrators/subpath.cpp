#include "pbrt/integrators/subpath.h"

#include <fmt/format.h>

namespace lacquer {

ScatterDensities DensitiesOf(const Bsdf& bsdf, Vec3 wi, TransportMode mode, ScatterDensities known,
                             ThreadState& state) {
    if (known.reverse > 0 && known.forward > 0) return known;
    // An estimate may be 0 where the density is not. Weights could then be 0 / 0.
    constexpr float kMin = 1e-4f;
    if (!(known.forward > 0)) known.forward = bsdf.Pdf(wi, {.mode = mode, .rng = &state.rng});
    const BxDFContext back{.mode = !mode, .rng = &state.rng};
    known.reverse = bsdf.bxdf->Pdf(bsdf.frame.ToLocal(wi), bsdf.wo, back);
    return {std::max(known.forward, kMin), std::max(known.reverse, kMin)};
}

namespace {

/// The end of a camera path that leaves the scene along `edge`.
PathVertex EscapedVertex(const SubpathEdge& edge) {
    PathVertex v;
    v.kind = PathVertex::Kind::Light;
    v.beta = edge.beta;
    v.isInfinite = true;
    v.toLight = edge.ray.d;
    v.pdfForward = edge.pdfDirection;
    return v;
}

/// Draws the edge that leaves `here`, and finds how likely the way back to `previous` is. What was drawn;
/// empty: the path ends.
std::optional<BxDFSample> SampleEdge(PathVertex& previous, PathVertex& here, TransportMode mode,
                                     SubpathEdge* edge, Sampler& sampler, ThreadState& state) {
    const BxDFContext context{.mode = mode, .rng = &state.rng, .counters = &state.bxdf};
    const float uLobe = sampler.Get1D();
    std::optional<BxDFSample> sample = here.bsdf.Sample({uLobe, sampler.Get2D()}, context);
    if (!sample) return sample;
    edge->beta *= sample->weight;
    if (mode == TransportMode::Importance) edge->beta *= ShadingNormalFactor(here.si, here.si.wo, sample->wi);
    if (!edge->beta) return std::nullopt;
    here.isDelta = sample->IsSpecular();
    ScatterDensities pdf{sample->pdfExact ? sample->pdf : 0, sample->pdfExact ? sample->pdfReverse : 0};
    if (!here.isDelta) pdf = DensitiesOf(here.bsdf, sample->wi, mode, pdf, state);
    previous.pdfReverse = here.ToArea(pdf.reverse, previous);
    edge->pdfDirection = pdf.forward;
    edge->ray = SpawnRay(here.si, sample->wi);
    return sample;
}

}  // namespace

void SubpathTracer::Extend(Subpath& path, TracedPath traced, SubpathEdge edge, SampledWavelengths& lambda,
                           Sampler& sampler, ThreadState& state) const {
    const size_t most = std::min(maxVertices, Subpath::kMax);
    const float start = edge.beta.MaxComponent();
    float etaScale = 1;
    bool anyNonSpecular = false;
    while (path.Size() < most) {
        PathVertex v;
        v.beta = edge.beta;
        if (!traced.Intersect(edge.ray, &v.si)) {
            if (mode == TransportMode::Radiance) path.Add(EscapedVertex(edge));
            return;
        }
        const AtSurface at = traced.Scatter(&v.si, lambda, &v.bsdf);
        if (at == AtSurface::Ends) return;
        if (at == AtSurface::Passes) {
            edge.ray = SpawnRay(v.si, edge.ray.d);
            continue;
        }
        PathVertex& previous = path[path.Size() - 1];
        if (previous.isInfinite && !IsLit(previous, v.si, lambda)) return;
        if (regularize && anyNonSpecular) v.bsdf.bxdf->Regularize();
        v.pdfForward = previous.ToArea(edge.pdfDirection, v);
        PathVertex& here = path.Add(v);
        if (path.Size() == most) return;

        const std::optional<BxDFSample> sample = SampleEdge(previous, here, mode, &edge, sampler, state);
        if (!sample) return;
        anyNonSpecular |= !here.isDelta;
        if (sample->IsTransmission() && mode == TransportMode::Radiance) etaScale *= Sqr(sample->eta);
        // Russian roulette, which the weights ignore: they may be any function of the path.
        const float survival = edge.beta.MaxComponent() * etaScale / start;
        if (roulette && path.Size() > 4 && survival < 1) {
            if (sampler.Get1D() >= survival) return;
            edge.beta /= survival;
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
    start.edge.pdfDirection = pdf.direction;

    const bool hasNormal = emitted->n != Normal3(0);
    const float cosine = hasNormal ? AbsDot(emitted->n, emitted->w) : 1.f;
    start.edge.beta = emitted->L * (cosine / (chosen->p * emitted->pdfPosition * emitted->pdfDirection));
    start.edge.ray = {hasNormal ? OffsetRayOrigin(v.si.p, v.si.pError, v.si.n, emitted->w) : v.si.p,
                      emitted->w, time};
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
        if (v.light->GetKind() != Light::Kind::Area || v.light->IsHoldout()) return std::nullopt;
        L *= v.light->L(v.si.p, v.si.n, v.si.uv, c->wi, lambda) * AbsDot(v.si.n, c->wi);
    } else {
        if (!IsNonSpecular(v.bsdf.Flags()) || v.si.material->IsHoldout()) return std::nullopt;
        const BxDFContext context{
            .mode = TransportMode::Importance, .rng = &state.rng, .needsPdf = false, .counters = &state.bxdf};
        scattering = v.bsdf.Evaluate(c->wi, context);
        L *= scattering.f * (ShadingNormalFactor(v.si, v.si.wo, c->wi) * AbsDot(c->wi, v.si.shading.n));
    }
    LightSample lens;
    lens.p = c->p;
    if (!L || !scene.Visible(v.si, lens, true, state.rays)) return std::nullopt;
    return CameraArrival{*c, L, scattering};
}

}  // namespace lacquer
