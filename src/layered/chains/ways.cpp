#include "layered/chains/ways.h"

#include <algorithm>

namespace lacquer::layered {
namespace {

float ReflectanceOf(const StackInterface& interface) {
    // Dielectrics that have no isotropic facets (smooth, anisotropic, leaning) are taken for one of glass.
    constexpr float kGlass = 0.04f;
    const auto facets = interface.IsotropicFacets();
    if (!facets) return interface.transmits ? kGlass : 1;
    if (facets->eta == 0) return 1;
    return Sqr((facets->eta - 1) / (facets->eta + 1));
}

}  // namespace

float StrengthOf(const Stack& stack, std::span<const int> way) {
    float strength = 1;
    for (size_t k = 1; k + 1 < way.size(); ++k) {
        const float reflectance = ReflectanceOf(stack.interfaces[size_t(way[k])]);
        strength *= way[k - 1] == way[k + 1] ? reflectance : 1 - reflectance;
    }
    return strength;
}

float LargestStrength(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices) {
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

float ShareOfWay(float strength, float largest) {
    constexpr float kOften = 10, kSmallest = 0.1f;
    // No strength: an index of 1 exactly.
    if (!(largest > 0)) return 1;
    return std::clamp(kOften * strength / largest, kSmallest, 1.f);
}

}  // namespace lacquer::layered
