#include "pbrt/integrators/subsurface.h"

namespace lacquer {
namespace {

/// More hits on one segment than any real surface has: never an endless loop.
constexpr int kMaxHits = 1000;
/// A segment is too short to be traced below this many errors of the entry point.
constexpr float kShortest = 16;

bool IsOf(const Material& material, const SurfaceInteraction& hit) {
    if (!hit.material) return false;
    return hit.material == &material || hit.material->Choose(TextureContext(hit), hit.wo) == &material;
}

/// Goes along the segment and keeps one of the hits with `material`, the k-th with probability 1/k. The
/// number of these hits; 0: `chosen` is not set.
int ChooseHit(TracedPath& path, const ProbeSegment& segment, float time, const Material& material, float u,
              SurfaceInteraction* chosen) {
    int count = 0;
    Point3 origin = segment.start;
    SurfaceInteraction hit;
    for (int i = 0; i < kMaxHits; ++i) {
        const float left = segment.length - Dot(origin - segment.start, segment.direction);
        if (!(left > 0)) break;
        if (!path.Intersect({origin, segment.direction, time}, &hit, left)) break;
        if (IsOf(material, hit)) {
            // What is left of u after each decision is uniform again.
            const float keep = 1 / float(++count);
            if (u < keep) {
                *chosen = hit;
                u = std::min(u / keep, OneMinusEpsilon);
            } else {
                u = std::min((u - keep) / (1 - keep), OneMinusEpsilon);
            }
        }
        origin = OffsetRayOrigin(hit.p, hit.pError, hit.n, segment.direction);
    }
    return count;
}

}  // namespace

std::optional<SubsurfaceExit> SampleSubsurfaceExit(TracedPath& path, const SurfaceInteraction& entry,
                                                   const Material& material, const BSSRDF& bssrdf,
                                                   Sampler& sampler, Arena& arena) {
    const float uAxis = sampler.Get1D();
    const Point2 uDisc = sampler.Get2D();
    const float uChoice = sampler.Get1D();
    const std::optional<ProbeSegment> segment = bssrdf.SampleProbe(uAxis, uDisc);
    if (!segment) return std::nullopt;

    SubsurfaceExit exit;
    if (segment->radius < kShortest * entry.pError) {
        exit.si = entry;
        exit.Sp = bssrdf.EffectiveAlbedo();
        exit.pdf = SampledSpectrum(1);
    } else {
        const int count = ChooseHit(path, *segment, entry.time, material, uChoice, &exit.si);
        if (count == 0) return std::nullopt;
        const BSSRDFValue value = bssrdf.Evaluate(exit.si.p, exit.si.n);
        exit.Sp = value.Sp;
        exit.pdf = value.pdf / float(count);
    }
    if (!exit.Sp || !(exit.pdf[0] > 0)) return std::nullopt;

    // Light leaves as seen from straight above; bumps at the exit are too small to matter after the blur.
    exit.si.wo = exit.si.shading.n;
    exit.bsdf = {bssrdf.ExitBxDF(arena), Frame::FromZX(exit.si.shading.n, exit.si.shading.dpdu),
                 Vec3(0, 0, 1), &material};
    return exit;
}

}  // namespace lacquer
