#include "layered/paths/long_paths/long_path_plan.h"

#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

/// A walk of the long path ends where the base happens to reflect into the refraction of the other side, and
/// that is rare where the base is smooth compared with the coat: connections do better there.
bool IsBaseRough(float alphaCoat, float alphaBase, bool isBeckmann, bool hasProduct) {
    if (!isBeckmann) return alphaCoat <= 3 * (alphaBase - 0.05f);
    return alphaCoat <= (hasProduct ? 2.5f : 2.1f) * alphaBase;
}

}  // namespace

LongPathPlan PlanLongPaths(const MicrofacetSurface& coat, const MicrofacetSurface& base, bool hasProduct) {
    const bool isBeckmann =
        coat.model == MicrofacetModel::Beckmann && base.model == MicrofacetModel::Beckmann;
    const float alphaCoat = coat.alphaX, alphaBase = base.alphaX;
    const bool paths = IsBaseRough(alphaCoat, alphaBase, isBeckmann, hasProduct);
    if (!hasProduct) {
        const PathMethod all = paths ? PathMethod::LongPathWalk : PathMethod::Connection;
        return {all, all, 1};
    }
    if (paths) {
        // On a very rough base the walk gets the shortest path for nearly nothing, and well.
        const bool isVeryRough = alphaBase >= 0.4f && (isBeckmann || alphaCoat <= 0.5f * alphaBase);
        return {isVeryRough ? PathMethod::LongPathWalk : PathMethod::Product, PathMethod::LongPathWalk, 1};
    }
    // The smoother the base, the more of the noise is the shortest path's.
    return {PathMethod::Product, PathMethod::Connection, std::clamp(2 * alphaBase / alphaCoat, 0.2f, 1.f)};
}

}  // namespace lacquer::layered
