// How the light between two directions divides, by a look at the stack and without a random number: for rules
// that choose a method for each query, and so in a few per cent of the time of an estimate.
#pragma once

#include <array>

#include "layered/stack.h"

namespace lacquer::layered {

/// The facets of a rough boundary, else null.
inline const MicrofacetSurface* FacetsOf(const StackInterface& interface) {
    return std::get_if<MicrofacetSurface>(&interface.model);
}

/// What a look at the stack and at both directions tells of the shortest path, without a random number.
struct LightForecast {
    /// -log of what it carries over what it carries in the middle of its lobe, for facets of Beckmann's
    /// distribution: squaredSlope / variance.
    float exponent = 0;
    float squaredSlope = 0;  ///< of the middle facet, or of that where light leaves, which the path needs
    float variance = 0;      ///< twice that of this slope along an axis, the facets at the ends included
    /// The larger variance of a facet's slope times squared slope of the direction outside: above 1 most of
    /// the facets towards a direction lie in shadow.
    float grazing = 0;
    /// The typical visible facet of an end reflects totally what comes in from there.
    bool reflectsTotally = false;
    std::array<float, 2> cosines{};  ///< behind the typical facet of each end
};

/// A forecast where the shortest path goes through rough boundaries: down to the second interface and up
/// again, or straight through two or three. False elsewhere. Some 40 ns; twice as long where facets are
/// anisotropic or normals perturbed. Half as long where the exponent is far above maxExponent, the largest
/// one that matters to who asks: it is rougher then, and nothing is known of grazing and total reflection.
bool ForecastLight(const Stack& stack, Vec3 wo, Vec3 wi, float maxExponent, LightForecast* forecast);

/// Light of all longer paths under a coat of index > 1 over light of the shortest one: within a factor of 3
/// or 4 up to exponents of 6, by comparison with estimates. Longer paths have one more reflection off the
/// base and one off the inside of the coat, whose facets make a wider lobe of less light.
float LightOfLongerPaths(const LightForecast& forecast, const MicrofacetSurface& coat,
                         const MicrofacetSurface& base);

/// The exponent of the path down to the base under two coats and up again, between directions above, where
/// all three have facets and both coats indices above 1.
float OnePassExponent(const std::array<const MicrofacetSurface*, 3>& facets, Vec3 wo, Vec3 wi);

}  // namespace lacquer::layered
