#include "pbrt/integrators/subpath.h"

#include <fmt/format.h>

#include <algorithm>

#include "pbrt/integrators/medium_flight.h"

namespace lacquer {

BxDFValue ScatteringAt(const PathVertex& v, Vec3 w, TransportMode mode, ThreadState& state) {
    if (v.kind == PathVertex::Kind::Medium) {
        if (!v.phase->IsChromatic()) {
            const PhaseValue value = v.phase->Evaluate(v.si.wo, w);
            return {SampledSpectrum(value.p), value.pdf, value.pdfReverse};
        }
        const SpectralPhaseValue value = v.phase->EvaluateSpectral(v.si.wo, w);
        return {value.p, value.pdf.Average(), value.pdfReverse.Average()};
    }
    const BxDFContext context{.mode = mode, .rng = &state.rng, .needsPdf = false, .counters = &state.bxdf};
    BxDFValue value = v.bsdf.Evaluate(w, context);
    if (!value.f) return value;
    value.f *= AbsDot(w, v.si.shading.n);
    if (mode == TransportMode::Importance) value.f *= ShadingNormalFactor(v.si, v.si.wo, w);
    return value;
}

ScatterDensities DensitiesAt(const PathVertex& v, Vec3 w, TransportMode mode, ScatterDensities known,
                             ThreadState& state) {
    if (v.kind == PathVertex::Kind::Medium || (known.reverse > 0 && known.forward > 0)) return known;
    // An estimate may be 0 where the density is not. Weights could then be 0 / 0.
    constexpr float kMin = 1e-4f;
    const Bsdf& bsdf = v.bsdf;
    if (!(known.forward > 0)) known.forward = bsdf.Pdf(w, {.mode = mode, .rng = &state.rng});
    const BxDFContext back{.mode = !mode, .rng = &state.rng};
    known.reverse = bsdf.bxdf->Pdf(bsdf.frame.ToLocal(w), bsdf.wo, back);
    return {std::max(known.forward, kMin), std::max(known.reverse, kMin)};
}

namespace {

/// What a vertex at the end of an edge has of it.
void Reach(const SubpathEdge& edge, PathVertex* v) {
    v->beta = edge.beta;
    v->pdfs = edge.pdfs.scattering;
    v->isAlone = edge.isAlone;
    v->knownT = edge.knownT;
    v->medium = edge.medium;
}

/// The end of a camera path that leaves the scene along `edge`.
PathVertex EscapedVertex(const SubpathEdge& edge) {
    PathVertex v;
    v.kind = PathVertex::Kind::Light;
    Reach(edge, &v);
    v.isInfinite = true;
    v.toLight = edge.ray.d;
    v.pdfForward = edge.pdfDirection;
    return v;
}

/// ShadowRay::knownT of a piece of an edge.
float KnownT(const Medium& medium, const Ray& ray, float length, const SampledWavelengths& lambda) {
    if (!medium.IsHomogeneous()) return 1;
    const MediumProperties properties = medium.Along(ray, lambda);
    return properties.sigma_s ? Exp(-length * properties.SigmaT()).Average() : 1.f;
}

/// Sends `edge` on from `here` along w.
void Leave(const PathVertex& here, Vec3 w, SubpathEdge* edge) {
    edge->knownT = 1;
    edge->medium = here.MediumToward(w);
    edge->ray = SpawnRay(here.si, w);
}
/// The same with the densities of both directions.
void Leave(PathVertex& previous, const PathVertex& here, Vec3 w, ScatterDensities pdf, SubpathEdge* edge) {
    previous.pdfReverse = here.ToArea(pdf.reverse, previous);
    edge->pdfDirection = pdf.forward;
    Leave(here, w, edge);
}

/// Draws the edge that leaves a surface, and finds how likely the way back to `previous` is. What was drawn;
/// empty: the path ends.
std::optional<BxDFSample> SampleSurface(PathVertex& previous, PathVertex& here, TransportMode mode,
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
    if (!here.isDelta) pdf = DensitiesAt(here, sample->wi, mode, pdf, state);
    Leave(previous, here, sample->wi, pdf, edge);
    return sample;
}

/// The same in a medium. False: the path ends.
bool SampleMedium(PathVertex& previous, const PathVertex& here, TransportMode mode, SubpathEdge* edge,
                  ThreadState& state) {
    const std::optional<DrawnDirection> drawn =
        SamplePhase(*here.phase, here.si.wo, &edge->beta, &edge->pdfs, state.rng);
    if (!drawn) return false;
    // Densities for weights are means over the wavelengths, whichever of them is the first.
    const BxDFValue value = ScatteringAt(here, drawn->wi, mode, state);
    Leave(previous, here, drawn->wi, {value.pdf, value.pdfReverse}, edge);
    return bool(edge->beta);
}

}  // namespace

SubpathEdge CameraEdge(const Scene& scene, const CameraRay& cameraRay, const SampledWavelengths& lambda) {
    SubpathEdge edge;
    edge.ray = cameraRay.ray;
    edge.medium = scene.CameraMedium();
    edge.followed = lambda;
    return edge;
}

Arrival FollowEdge(SubpathEdge* edge, TracedPath* traced, PathVertex* from, PathVertex* v,
                   const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) {
    const bool hit = traced->Intersect(edge->ray, &v->si);
    if (edge->medium) {
        const Medium& medium = *edge->medium;
        const float tMax = hit ? Dot(v->si.p - edge->ray.o, edge->ray.d) : kMaxRayDistance;
        const MediumFlight flight =
            FlyThrough(medium, edge->ray, tMax, lambda, &edge->beta, &edge->pdfs, sampler, state.rng,
                       [&](SampledSpectrum light, SampledSpectrum pdfs) {
                           if (from) from->glow += OverMeanPdf(light, pdfs, edge->isAlone);
                       });
        traced->Cover(flight.covered);
        if (flight.end == MediumFlight::End::Absorbed) return Arrival::Ends;
        const bool scatters = flight.end == MediumFlight::End::Scattered;
        const float length = scatters ? Length(flight.p - edge->ray.o) : tMax;
        edge->knownT *= KnownT(medium, edge->ray, length, lambda);
        if (scatters) {
            v->kind = PathVertex::Kind::Medium;
            v->phase = &medium.Phase(lambda, state.arena);
            v->si = InMedium(flight.p, edge->ray);
            Reach(*edge, v);
            return traced->ScatterInMedium() ? Arrival::AtVertex : Arrival::Ends;
        }
    }
    if (!hit) return Arrival::Escapes;
    switch (traced->Scatter(&v->si, edge->followed, &v->bsdf)) {
        case AtSurface::Ends:
            return Arrival::Ends;
        case AtSurface::Passes:
            edge->medium = v->si.MediumToward(edge->ray.d, edge->medium);
            edge->ray = SpawnRay(v->si, edge->ray.d);
            return Arrival::Passes;
        case AtSurface::Scatters:
            break;
    }
    // Where the caller's wavelengths had been ended before, they are one for all.
    edge->isAlone = edge->followed.SecondaryTerminated() && !lambda.SecondaryTerminated();
    v->kind = PathVertex::Kind::Surface;
    Reach(*edge, v);
    return Arrival::AtVertex;
}

void RecordFirstHit(const PathSurroundings& surroundings, const CameraRay& cameraRay,
                    const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) {
    if (!state.firstHit) return;
    TracedPath traced = TracedPath::FromCamera(surroundings, cameraRay, 0, state);
    SubpathEdge edge = CameraEdge(surroundings.scene, cameraRay, lambda);
    PathVertex v;
    while (FollowEdge(&edge, &traced, nullptr, &v, lambda, sampler, state) == Arrival::Passes) {
    }
}

bool ScatterLight(PathVertex* v, SubpathEdge* edge, Sampler& sampler, ThreadState& state) {
    Vec3 w;
    if (v->kind == PathVertex::Kind::Medium) {
        const std::optional<DrawnDirection> drawn =
            SamplePhase(*v->phase, v->si.wo, &edge->beta, &edge->pdfs, state.rng);
        if (!drawn) return false;
        v->isDelta = false;
        w = drawn->wi;
    } else {
        const BxDFContext context{
            .mode = TransportMode::Importance, .rng = &state.rng, .needsPdf = false, .counters = &state.bxdf};
        const float uLobe = sampler.Get1D();
        const std::optional<BxDFSample> sample = v->bsdf.Sample({uLobe, sampler.Get2D()}, context);
        if (!sample) return false;
        v->isDelta = sample->IsSpecular();
        edge->beta *= sample->weight * ShadingNormalFactor(v->si, v->si.wo, sample->wi);
        w = sample->wi;
    }
    Leave(*v, w, edge);
    return bool(edge->beta);
}

void SubpathTracer::Extend(Subpath& path, TracedPath traced, SubpathEdge edge,
                           const SampledWavelengths& lambda, Sampler& sampler, ThreadState& state) const {
    const size_t most = std::min(maxVertices, Subpath::kMax);
    const float start = edge.Carried();
    float etaScale = 1;
    bool anyNonSpecular = false;
    while (path.Size() < most) {
        PathVertex &previous = path[path.Size() - 1], &here = path.Next();
        const Arrival arrival = FollowEdge(&edge, &traced, &previous, &here, lambda, sampler, state);
        if (arrival == Arrival::Passes) continue;
        if (arrival == Arrival::Escapes && mode == TransportMode::Radiance) path.Add(EscapedVertex(edge));
        if (arrival != Arrival::AtVertex) return;
        if (previous.isInfinite && !IsLit(previous, here.si, lambda)) return;
        const bool isSurface = here.kind == PathVertex::Kind::Surface;
        if (isSurface && regularize && anyNonSpecular) here.bsdf.bxdf->Regularize();
        here.pdfForward = previous.ToArea(edge.pdfDirection, here);
        path.Keep();
        if (path.Size() == most) return;

        if (isSurface) {
            const std::optional<BxDFSample> sample =
                SampleSurface(previous, here, mode, &edge, sampler, state);
            if (!sample) return;
            if (sample->IsTransmission() && mode == TransportMode::Radiance) etaScale *= Sqr(sample->eta);
        } else if (!SampleMedium(previous, here, mode, &edge, state)) {
            return;
        }
        anyNonSpecular |= !here.isDelta;
        // Russian roulette, which the weights ignore: they may be any function of the path.
        const float survival = edge.Carried() * etaScale / start;
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
    const LightMedia media = emitters.MediaOf(chosen->light);
    v.si.mediumInterface = media.interface;
    v.medium = media.around;
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
    start.edge.medium = v.MediumToward(emitted->w);
    start.edge.followed = lambda;
    return start;
}

bool IsLit(const PathVertex& start, const SurfaceInteraction& si, const SampledWavelengths& lambda) {
    if (!start.isInfinite || !start.light->IsInfinite()) return true;
    return bool(start.light->Le({si.p, start.toLight, si.time}, lambda));
}

std::string WhyNoLightPaths(const Scene& scene) {
    if (!scene.HasMedia()) return "";
    const bool anyFar = std::ranges::any_of(scene.Lights(), [](const Light* light) {
        return light->IsInfinite() || light->GetKind() == Light::Kind::DeltaDirection;
    });
    return anyFar && OutermostMedium(scene)
               ? "begins no paths at distant and infinite lights in a medium without walls"
               : "";
}

void RequireImportance(const IntegratorArgs& args) {
    if (const std::string why = args.scene.Camera().WhyNoImportance(); !why.empty())
        throw SceneError(args.params.Loc(), fmt::format("{}: {}", args.params.Owner(), why));
}

namespace {

/// The camera sees no light of holdouts.
bool IsHeldOut(const PathVertex& v) {
    return v.kind == PathVertex::Kind::Surface && v.si.material->IsHoldout();
}

}  // namespace

std::optional<CameraArrival> ConnectToCamera(const Scene& scene, const PathVertex& v, Point2 uLens,
                                             const SampledWavelengths& lambda, ThreadState& state) {
    const std::optional<CameraConnection> c = scene.Camera().SampleWi(v.si.p, v.si.time, uLens);
    if (!c || !state.film->IsInSplatRange(c->pFilm)) return std::nullopt;
    CameraArrival arrival;
    arrival.camera = *c;
    arrival.L = v.beta * (c->importance / c->pdf);
    if (v.kind == PathVertex::Kind::Light) {
        // Only area lights can be seen in this way.
        if (v.light->GetKind() != Light::Kind::Area || v.light->IsHoldout()) return std::nullopt;
        arrival.L *= v.light->L(v.si.p, v.si.n, v.si.uv, c->wi, lambda) * AbsDot(v.si.n, c->wi);
    } else {
        if (!IsConnectible(v) || IsHeldOut(v)) return std::nullopt;
        arrival.scattering = ScatteringAt(v, c->wi, TransportMode::Importance, state);
        arrival.L *= arrival.scattering.f;
    }
    if (!arrival.L) return std::nullopt;
    LightSample lens;
    lens.p = c->p;
    const ShadowRay shadow = TraceShadowRay(scene, v.si, lens, c->wi, v.medium, lambda, state);
    if (!shadow.T) return std::nullopt;
    arrival.L = OverMeanPdf(arrival.L * shadow.T, v.pdfs * shadow.pdfs.light, v.isAlone);
    arrival.knownT = shadow.knownT;
    return arrival;
}

}  // namespace lacquer
