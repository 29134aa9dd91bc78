#include "layered/lobes/facet_albedo.h"

#include <array>

namespace lacquer::layered {
namespace {

constexpr size_t kFacets = 16;
using Numbers = std::array<float, kFacets>;

/// Slopes of facets of alpha 1 along the plane of incidence, and their squared lengths: equal parts of the
/// distribution by radius, and one half of all azimuths.
struct SlopeTable {
    Numbers along, square;
    explicit SlopeTable(MicrofacetModel model) {
        constexpr int kRadii = 4, kAzimuths = 4;
        for (int i = 0; i < kRadii; ++i)
            for (int j = 0; j < kAzimuths; ++j) {
                const size_t k = size_t(i * kAzimuths + j);
                const float u = (float(i) + 0.5f) / kRadii;
                // The azimuths of a ring are those of its neighbours, turned by a part of their distance.
                const float phi = (float(j) + (float(i) + 0.5f) / kRadii) * Pi / kAzimuths;
                square[k] = model == MicrofacetModel::Beckmann ? -std::log(1 - u) : u / (1 - u);
                along[k] = std::sqrt(square[k]) * std::cos(phi);
            }
    }
};

/// Projected area of facets in Trowbridge and Reitz' form [Heitz 2014]. Beckmann's take alpha^2/pi in place
/// of alpha^2, which is right in the horizon.
float Area(float z, float alpha2) {
    return 0.5f * (z + std::sqrt(std::max(z * z + alpha2 * (1 - z * z), 0.f)));
}

}  // namespace

FacetAlbedo IntegrateFacets(MicrofacetModel model, float alpha, float eta, float cosTheta,
                            float alphaShadow) {
    static const std::array tables = {SlopeTable(MicrofacetModel::TrowbridgeReitz),
                                      SlopeTable(MicrofacetModel::Beckmann)};
    const SlopeTable& table = tables[model == MicrofacetModel::Beckmann];
    const float sinTheta = SafeSqrt(1 - cosTheta * cosTheta), alpha2 = alpha * alpha;
    const float shadow2 = Sqr(alphaShadow) * (model == MicrofacetModel::Beckmann ? InvPi : 1.f);
    const float areaO = Area(cosTheta, shadow2);
    const float index = eta > 0 ? eta : 1.f;
    float sum = 0, reflected = 0, transmitted = 0;
    // No branches: all facets at once.
    for (size_t k = 0; k < kFacets; ++k) {
        // Visible facets: weighted by the projected area.
        const float projected = std::max(cosTheta - sinTheta * alpha * table.along[k], 0.f);
        const float cosFacet = 1 / std::sqrt(1 + alpha2 * table.square[k]);
        const float c = std::min(projected * cosFacet, 1.f);
        const float cos2Beyond = 1 - (1 - c * c) / (index * index);
        const float beyond = std::sqrt(std::max(cos2Beyond, 0.f));
        const float a = (index * c - beyond) / (index * c + beyond + 1e-9f),
                    b = (c - index * beyond) / (c + index * beyond + 1e-9f);
        const float fresnel = eta > 0 && cos2Beyond > 0 ? 0.5f * (a * a + b * b) : 1.f;
        // Where the light goes, and what other facets leave of it: G/G1.
        const float up = 2 * c * cosFacet - cosTheta;
        const float down = (cosTheta - c * cosFacet) / index + beyond * cosFacet;
        const auto unshadowed = [&](float z) {
            const float area = Area(std::max(z, 0.f), shadow2);
            return std::max(z, 0.f) * areaO /
                   (areaO * std::max(z, 0.f) + (area - std::max(z, 0.f)) * cosTheta + 1e-9f);
        };
        sum += projected;
        reflected += projected * fresnel * unshadowed(up);
        transmitted += projected * (1 - fresnel) * unshadowed(down);
    }
    return sum > 0 ? FacetAlbedo{reflected / sum, transmitted / sum} : FacetAlbedo{1, 0};
}

}  // namespace lacquer::layered
