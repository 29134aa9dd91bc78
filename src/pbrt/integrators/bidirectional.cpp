#include "pbrt/integrators/bidirectional.h"

namespace lacquer {
namespace {

/// What connecting changes of two subpaths, s vertices from the light and t from the camera: the densities at
/// their ends. Empty vertices beyond the ends of a path are never read.
struct Connection {
    const Subpath& lightPath;
    const Subpath& cameraPath;
    size_t s, t;
    const PathVertex*
        light;  ///< vertex s - 1 of the light path, or what was drawn in its place; null if s is 0
    float lightReverse = 0, lightBeforeReverse = 0;    ///< of the vertices s - 1 and s - 2, over area
    float cameraReverse = 0, cameraBeforeReverse = 0;  ///< of the vertices t - 1 and t - 2, over area
    /// Density with which a light's point is drawn for the first vertex after it, over that with which paths
    /// from the lights begin there.
    float directRatio = 1;
    bool lightIsDelta = false;  ///< no ray from the camera hits it
    float knownT = 1;           ///< of the connection (PathVertex::knownT)
};

/// Less transmittance counts as this much: what differs by more is of no strategy's weight any more.
constexpr float kMinT = 1e-10f;

/// Weight of a strategy among all that make the same path [Veach 1997, sec. 10.2.1]. Quotients of the
/// densities of neighbouring strategies differ at one vertex only.
float Weight(const Connection& c) {
    if (c.s + c.t == 2) return 1;
    // The one strategy that draws the light's point for a given vertex.
    const auto direct = [&](size_t s) { return s == 1 ? double(c.directRatio) : 1.; };
    // The one edge that a strategy connects is the one whose flight it does not draw.
    const auto drawn = [](double density, float knownT) {
        return Sqr(density / double(std::max(knownT, kMinT)));
    };
    double sum = 0;

    // Strategies with more vertices from the light.
    double ratio = 1;
    for (size_t i = c.t - 1; i > 0; --i) {
        const PathVertex& v = c.cameraPath[i];
        const float reverse = i == c.t - 1   ? c.cameraReverse
                              : i == c.t - 2 ? c.cameraBeforeReverse
                                             : v.pdfReverse;
        if (!(v.pdfForward > 0)) return 0;
        ratio *= double(reverse) / double(v.pdfForward);
        const bool isDelta = (i < c.t - 1 && v.isDelta) || c.cameraPath[i - 1].isDelta;
        if (!isDelta) sum += drawn(ratio * direct(c.s + c.t - i), v.knownT);
    }
    // Strategies with more vertices from the camera.
    ratio = 1;
    for (size_t i = c.s; i-- > 0;) {
        const PathVertex& v = i == c.s - 1 ? *c.light : c.lightPath[i];
        const float reverse = i == c.s - 1   ? c.lightReverse
                              : i + 2 == c.s ? c.lightBeforeReverse
                                             : v.pdfReverse;
        if (!(v.pdfForward > 0)) return 0;
        ratio *= double(reverse) / double(v.pdfForward);
        const bool isDelta =
            (i < c.s - 1 && v.isDelta) || (i > 0 ? c.lightPath[i - 1].isDelta : c.lightIsDelta);
        // That with none from the light connects nothing.
        if (!isDelta) sum += drawn(ratio * direct(i), i == 0 ? 1.f : v.knownT);
    }
    const double own = drawn(direct(c.s), c.knownT);
    const double weight = own / (own + sum);
    return std::isfinite(weight) ? float(weight) : 0.f;
}

/// A light as a vertex next to a surface point.
/// @param pdf  of light that leaves toward the surface point
PathVertex LightVertex(const Light& light, float pmf, const LightSample& ls, float time,
                       EmissionDensity pdf) {
    PathVertex v;
    v.kind = PathVertex::Kind::Light;
    v.light = &light;
    v.isInfinite = light.IsInfinite() || light.GetKind() == Light::Kind::DeltaDirection;
    v.toLight = ls.wi;
    v.si.p = ls.p;
    v.si.pError = ls.pError;
    v.si.n = v.si.shading.n = ls.n;
    v.si.time = time;
    v.pdfForward = pmf * (v.isInfinite ? pdf.direction : pdf.position);
    v.pdfPlane = v.isInfinite ? pdf.position : 0;
    return v;
}

/// Density of a light's point when it is drawn for a surface point, over that of `light` as the beginning
/// of a path.
/// @param pdfLi  over solid angle at the surface point
float DirectRatio(const PathVertex& surface, const PathVertex& light, float pdfLi, float pmf) {
    if (light.light->IsDelta()) return 1;
    const float ratio = pmf * surface.ToArea(pdfLi, light) / light.pdfForward;
    return std::isfinite(ratio) ? ratio : 0.f;
}

}  // namespace

void BidirectionalStrategies::TraceCameraPath(Subpath& path, size_t maxVertices, const CameraRay& cameraRay,
                                              const SampledWavelengths& lambda, Sampler& sampler,
                                              ThreadState& state) const {
    PathVertex camera;
    camera.kind = PathVertex::Kind::Camera;
    camera.si.p = cameraRay.ray.o;
    camera.si.n = camera.si.shading.n = Normal3(0);
    camera.si.time = cameraRay.ray.time;
    camera.beta = SampledSpectrum(1);
    camera.medium = scene_.CameraMedium();
    path.Add(camera);
    SubpathEdge edge = CameraEdge(scene_, cameraRay, lambda);
    edge.pdfDirection = scene_.Camera().PdfWe(cameraRay.ray);
    SubpathTracer{TransportMode::Radiance, maxVertices, regularize_, roulette_}.Extend(
        path, TracedPath::FromCamera(surroundings_, cameraRay, TracedPath::kUnlimited, state), edge, lambda,
        sampler, state);
}

void BidirectionalStrategies::TraceLightPath(Subpath& path, size_t maxVertices, float time,
                                             const SampledWavelengths& lambda, Sampler& sampler,
                                             ThreadState& state) const {
    const std::optional<LightStart> start = StartAtLight(emitters_, time, lambda, sampler);
    if (!start) return;
    path.Add(start->vertex);
    SubpathTracer{TransportMode::Importance, maxVertices, regularize_, roulette_}.Extend(
        path, TracedPath::FromLight(surroundings_, state), start->edge, lambda, sampler, state);
}

SampledSpectrum BidirectionalStrategies::Emission(const Subpath& lightPath, const Subpath& cameraPath,
                                                  size_t t, const SampledWavelengths& lambda) const {
    const PathVertex& v = cameraPath[t - 1];
    if (v.kind == PathVertex::Kind::Medium) return SampledSpectrum(0);
    if (v.kind == PathVertex::Kind::Surface) {
        if (!v.si.areaLight) return SampledSpectrum(0);
        const SampledSpectrum Le = v.si.areaLight->L(v.si.p, v.si.n, v.si.uv, v.si.wo, lambda);
        if (!Le) return Le;
        LightSample at;
        at.wi = -v.si.wo;
        at.p = v.si.p;
        at.n = v.si.n;
        return OverMeanPdf(v.beta * Le * EmissionWeight(lightPath, cameraPath, t, *v.si.areaLight, at),
                           v.pdfs, v.isAlone);
    }
    SampledSpectrum sum(0);
    const PathVertex& before = cameraPath[t - 2];
    for (const Light* light : scene_.InfiniteLights()) {
        const SampledSpectrum Le = light->Le({before.si.p, v.toLight, before.si.time}, lambda);
        if (!Le) continue;
        LightSample at;
        at.wi = v.toLight;
        sum += Le * EmissionWeight(lightPath, cameraPath, t, *light, at);
    }
    return OverMeanPdf(v.beta * sum, v.pdfs, v.isAlone);
}

float BidirectionalStrategies::EmissionWeight(const Subpath& lightPath, const Subpath& cameraPath, size_t t,
                                              const Light& light, const LightSample& at) const {
    if (t == 2) return 1;
    const PathVertex& before = cameraPath[t - 2];
    const float pmf = emitters_.Pmf(&light);
    const EmissionDensity pdf = light.PdfLe(at.n, -at.wi);
    const PathVertex v = LightVertex(light, pmf, at, before.si.time, pdf);
    Connection c{lightPath, cameraPath, 0, t, nullptr};
    c.cameraReverse = v.pdfForward;
    c.cameraBeforeReverse = v.ToArea(pdf.direction, before);
    if (!before.isDelta) {
        const float pdfLi = light.PdfLi(LightReference(before.si), at.wi, &v.si);
        c.directRatio = DirectRatio(before, v, pdfLi, pmf);
    }
    return Weight(c);
}

SampledSpectrum BidirectionalStrategies::DirectLight(const Subpath& lightPath, const Subpath& cameraPath,
                                                     size_t t, const SampledWavelengths& lambda,
                                                     Sampler& sampler, ThreadState& state) const {
    const PathVertex& v = cameraPath[t - 1];
    const PathVertex& before = cameraPath[t - 2];
    const float uLight = sampler.Get1D();
    const Point2 u = sampler.Get2D();
    const std::optional<SampledLight> chosen = emitters_.Sample(uLight);
    if (!chosen || !(chosen->p > 0)) return SampledSpectrum(0);
    const std::optional<LightSample> ls = chosen->light->SampleLi(LightReference(v.si), u, lambda);
    if (!ls) return SampledSpectrum(0);
    const BxDFValue value = ScatteringAt(v, ls->wi, TransportMode::Radiance, state);
    if (!value.f) return value.f;
    const ShadowRay shadow = TraceShadowRay(scene_, v.si, *ls, ls->wi, v.medium, lambda, state);
    if (!shadow.T) return shadow.T;

    const EmissionDensity pdfLe = chosen->light->PdfLe(ls->n, -ls->wi);
    const PathVertex light = LightVertex(*chosen->light, chosen->p, *ls, v.si.time, pdfLe);
    const ScatterDensities pdf = DensitiesAt(v, ls->wi, TransportMode::Radiance, value, state);
    Connection c{lightPath, cameraPath, 1, t, &light};
    c.lightReverse = v.ToArea(pdf.forward, light);
    c.cameraReverse = light.ToArea(pdfLe.direction, v);
    c.cameraBeforeReverse = v.ToArea(pdf.reverse, before);
    c.directRatio = DirectRatio(v, light, ls->pdf, chosen->p);
    c.lightIsDelta = chosen->light->IsDelta();
    c.knownT = shadow.knownT;
    return OverMeanPdf(v.beta * value.f * shadow.T * ls->L * (Weight(c) / (ls->pdf * chosen->p)),
                       v.pdfs * shadow.pdfs.light, v.isAlone);
}

float BidirectionalStrategies::DirectRatioOf(const Subpath& lightPath) const {
    const PathVertex &light = lightPath[0], &v = lightPath[1];
    if (light.light->IsDelta()) return 1;
    const float pdfLi = light.light->PdfLi(LightReference(v.si), v.DirectionTo(light), &light.si);
    return DirectRatio(v, light, pdfLi, emitters_.Pmf(light.light));
}

std::optional<FilmLight> BidirectionalStrategies::CameraLight(const Subpath& lightPath,
                                                              const Subpath& cameraPath, size_t s,
                                                              const SampledWavelengths& lambda,
                                                              Sampler& sampler, ThreadState& state) const {
    const PathVertex& v = lightPath[s - 1];
    const PathVertex& before = lightPath[s - 2];
    const std::optional<CameraArrival> arrival = ConnectToCamera(scene_, v, sampler.Get2D(), lambda, state);
    if (!arrival) return std::nullopt;
    PathVertex camera;
    camera.si.p = arrival->camera.p;
    camera.si.n = Normal3(0);
    const ScatterDensities pdf =
        DensitiesAt(v, arrival->camera.wi, TransportMode::Importance, arrival->scattering, state);
    Connection c{lightPath, cameraPath, s, 1, &v};
    c.lightReverse =
        camera.ToArea(scene_.Camera().PdfWe({arrival->camera.p, -arrival->camera.wi, v.si.time}), v);
    c.lightBeforeReverse = v.ToArea(pdf.reverse, before);
    c.directRatio = DirectRatioOf(lightPath);
    c.lightIsDelta = lightPath[0].light->IsDelta();
    c.knownT = arrival->knownT;
    return FilmLight{arrival->camera.pFilm, arrival->L * Weight(c)};
}

SampledSpectrum BidirectionalStrategies::Connect(const Subpath& lightPath, const Subpath& cameraPath,
                                                 size_t s, size_t t, const SampledWavelengths& lambda,
                                                 ThreadState& state) const {
    const PathVertex &q = lightPath[s - 1], &p = cameraPath[t - 1];
    const Vec3 d = q.si.p - p.si.p;
    const float distanceSquared = LengthSquared(d);
    if (!(distanceSquared > 0)) return SampledSpectrum(0);
    const Vec3 w = d / std::sqrt(distanceSquared);
    const BxDFValue atCamera = ScatteringAt(p, w, TransportMode::Radiance, state);
    if (!atCamera.f) return SampledSpectrum(0);
    const BxDFValue atLight = ScatteringAt(q, -w, TransportMode::Importance, state);
    const SampledSpectrum L = p.beta * atCamera.f * atLight.f * q.beta / distanceSquared;
    if (!L) return SampledSpectrum(0);
    LightSample target;
    target.p = q.si.p;
    target.pError = q.si.pError;
    target.n = q.si.n;
    const ShadowRay shadow = TraceShadowRay(scene_, p.si, target, w, p.medium, lambda, state);
    if (!shadow.T) return shadow.T;

    const ScatterDensities pdfCamera = DensitiesAt(p, w, TransportMode::Radiance, atCamera, state);
    const ScatterDensities pdfLight = DensitiesAt(q, -w, TransportMode::Importance, atLight, state);
    Connection c{lightPath, cameraPath, s, t, &q};
    c.lightReverse = p.ToArea(pdfCamera.forward, q);
    c.lightBeforeReverse = q.ToArea(pdfLight.reverse, lightPath[s - 2]);
    c.cameraReverse = q.ToArea(pdfLight.forward, p);
    c.cameraBeforeReverse = p.ToArea(pdfCamera.reverse, cameraPath[t - 2]);
    c.directRatio = DirectRatioOf(lightPath);
    c.lightIsDelta = lightPath[0].light->IsDelta();
    c.knownT = shadow.knownT;
    return OverMeanPdf(L * shadow.T * Weight(c), p.pdfs * q.pdfs * shadow.pdfs.light, p.isAlone || q.isAlone);
}

}  // namespace lacquer
