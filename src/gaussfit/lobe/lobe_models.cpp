#include "gaussfit/lobe/lobe_models.h"

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"

namespace lacquer::gaussfit {

namespace {

/// A mirror of facets, without Fresnel's factor: a conductor of index 0 reflects all light. Leaving the
/// factor out costs little in the products and saves the dimension of the index [Xia et al. 2020, sec. 6].
template <class Distribution>
float ReflectedByMirror(float alpha, float /*eta*/, Vec3 w, Vec3 v) {
    const ConductorBxDF<Distribution> mirror({alpha, alpha}, SampledSpectrum(0.f), SampledSpectrum(0.f));
    return mirror.Evaluate(w, v, {.needsPdf = false}).f[0];
}

template <class Distribution>
float RefractedByDielectric(float alpha, float eta, Vec3 w, Vec3 v) {
    // The index below the surface over the one above it; w is above.
    const DielectricBxDF<Distribution> boundary({alpha, alpha}, eta);
    return boundary.Evaluate(w, v, {.mode = TransportMode::Importance, .needsPdf = false}).f[0];
}

constexpr auto kBeckmann = MicrofacetModel::Beckmann, kGGX = MicrofacetModel::TrowbridgeReitz;

// Powers of the cosine: over slopes, the product of two slices has the density f f cos^4. Two transmissions
// share that power; with a reflection, products fit best if the reflection alone has all of it. Transmissions
// of GGX need 4 as well: its long tails let light through facets that stand almost along it, and with 2
// nearly all of a grazing slice lies at the horizon, where no other lobe is.
constexpr LobeModel kModels[] = {
    {"beckmann-reflection", kBeckmann, LobeEvent::Reflection, 1, 4, ReflectedByMirror<Beckmann>},
    {"beckmann-entering", kBeckmann, LobeEvent::Entering, 1, 2, RefractedByDielectric<Beckmann>},
    {"beckmann-leaving", kBeckmann, LobeEvent::Leaving, 1, 2, RefractedByDielectric<Beckmann>},
    {"trowbridgereitz-reflection", kGGX, LobeEvent::Reflection, 2, 4, ReflectedByMirror<TrowbridgeReitz>},
    {"trowbridgereitz-entering", kGGX, LobeEvent::Entering, 2, 4, RefractedByDielectric<TrowbridgeReitz>},
    {"trowbridgereitz-leaving", kGGX, LobeEvent::Leaving, 2, 4, RefractedByDielectric<TrowbridgeReitz>},
};

}  // namespace

std::span<const LobeModel> LobeModels() { return kModels; }

const LobeModel* FindLobeModel(std::string_view name) {
    for (const LobeModel& model : kModels)
        if (name == model.name) return &model;
    return nullptr;
}

}  // namespace lacquer::gaussfit
