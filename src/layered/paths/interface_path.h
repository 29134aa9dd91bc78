// A path of light through a stack that no slab scatters. Where all interfaces on it are rough, this is one
// smooth integral over few inner directions, and product estimators draw all of them together. The shortest
// path goes down to the second interface and up again, or straight through.
#pragma once

#include <array>
#include <span>

#include "layered/slopes/facet_slopes.h"

namespace lacquer::layered {

/// A vertex of the path, on one interface.
struct PathEvent {
    const StackInterface* interface = nullptr;
    MicrofacetSurface surface{};
    bool transmits = false;
    /// Index on the side where light comes from over index on the side where it goes, in the order of the
    /// path; 1 for reflections.
    float eta = 1;
    Symmetric2 slopeCovariance;  ///< of the facets' relative slopes: FacetCovariance()

    bool IsIsotropic() const { return layered::IsIsotropic(*interface, surface); }
    bool HasUnperturbedNormal() const { return interface->HasUnperturbedNormal(); }
    RelativeSlopes Slopes() const { return RelativeSlopes(*interface); }
    float MaxAlpha() const { return std::max(surface.alphaX, surface.alphaY); }
    float MeanAlpha() const { return layered::MeanAlpha(surface); }
};

/// Events in the order of light: event 0 is where wi meets the stack, the last one where wo leaves it.
/// Inner direction k joins events k and k+1.
struct InterfacePath {
    static constexpr int kMaxEvents = 7, kMaxInner = kMaxEvents - 1;
    static constexpr int kMaxShortestEvents = 3;  ///< of shortest paths

    std::array<PathEvent, kMaxEvents> events;
    std::array<const Slab*, kMaxInner> slabs{};  ///< that the inner directions cross
    /// Sign of z of the inner directions, as seen from event k towards event k+1: the order of the interfaces
    /// fixes it.
    std::array<float, kMaxInner> signs{};
    int numEvents = 0;
    Vec3 wi, wo;  ///< outside, unit, both away from the stack

    int NumInner() const { return numEvents - 1; }
};

/// Inner directions, unit, in the direction of light: from event k towards event k+1.
using InnerDirections = std::array<Vec3, InterfacePath::kMaxInner>;

/// Densities of the inner directions [1/sr].
using InnerDensities = std::array<float, InterfacePath::kMaxInner>;

/// Sets the shortest path between two outer directions. False if there is none of 2 or 3 events and of at
/// most `maxVertices`, or if one of its interfaces is not a rough boundary of microfacets or has a normal
/// more than 70 degrees off the stack's.
bool FindShortestPath(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices, InterfacePath* path);
/// Sets the path that meets these interfaces, 2 to InterfacePath::kMaxEvents, each next to the one before;
/// the first one is that which wi meets, the last one that which wo leaves. False for interfaces as above.
bool SetInterfacePath(const Stack& stack, Vec3 wo, Vec3 wi, std::span<const int> interfaces,
                      InterfacePath* path);

/// The path's integrand [1/sr per sr of each inner direction]: the product of all f, of the cosines of the
/// inner directions and of what the slabs let through, scattered light counting as lost. Exact; needs no
/// random numbers. 0 for inner directions on the wrong side.
/// @param densities  what the integrand is divided by, factor by factor: products of many sharp lobes leave
///                   the range of a float
SampledSpectrum PathContribution(const InterfacePath& path, const InnerDirections& inner, TransportMode mode,
                                 const InnerDensities* densities = nullptr);

}  // namespace lacquer::layered
