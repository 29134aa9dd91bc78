#include "layered/paths/interface_sequences.h"

#include <algorithm>

namespace lacquer::layered {
namespace {

float ReflectanceOf(const StackInterface& interface) {
    // Dielectrics that have no isotropic facets (smooth, anisotropic, with a perturbed normal) are taken for
    // one of glass.
    constexpr float kGlass = 0.04f;
    const auto facets = interface.IsotropicFacets();
    if (!facets) return interface.transmits ? kGlass : 1;
    if (facets->eta == 0) return 1;
    return Sqr((facets->eta - 1) / (facets->eta + 1));
}

}  // namespace

float SmoothThroughput(const Stack& stack, std::span<const int> sequence) {
    float throughput = 1;
    for (size_t k = 1; k + 1 < sequence.size(); ++k) {
        const float reflectance = ReflectanceOf(stack.interfaces[size_t(sequence[k])]);
        throughput *= sequence[k - 1] == sequence[k + 1] ? reflectance : 1 - reflectance;
    }
    return throughput;
}

float LargestSmoothThroughput(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices) {
    const int first = stack.OuterTowards(wi), step = wi.z > 0 ? 1 : -1;
    const bool isReflection = SameHemisphere(wo, wi);
    float passed = 1, largest = 0;
    for (int k = 1; k <= stack.Last() && (!isReflection || 2 * k < maxVertices); ++k) {
        const float reflectance = ReflectanceOf(stack.interfaces[size_t(first + k * step)]);
        largest = std::max(largest, passed * reflectance);
        if (k < stack.Last()) passed *= isReflection ? Sqr(1 - reflectance) : 1 - reflectance;
    }
    return isReflection ? largest : passed;
}

float SequenceProbability(float throughput, float largest) {
    constexpr float kOften = 10, kSmallest = 0.1f;
    // No strength: an index of 1 exactly.
    if (!(largest > 0)) return 1;
    return std::clamp(kOften * throughput / largest, kSmallest, 1.f);
}

}  // namespace lacquer::layered
