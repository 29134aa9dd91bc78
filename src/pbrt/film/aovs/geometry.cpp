// Auxiliary outputs of the first hit's geometry, means over the samples that hit something:
//   normal, ng   shading and geometric normal, unit vectors
//   position     in world or camera space
//   depth        along the camera's axis
//   uv           surface coordinates
//   slope        of the depth from one pixel to the next; of the gbuffer film
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

template <int n>
void MeanOverHits(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    for (int i = 0; i < n; ++i) out[i] = counts.hits > 0 ? float(sums[i] / counts.hits) : 0.f;
}

void Direction(const ColorSpace&, const AovCounts&, const double* sums, float* out) {
    const double length = std::sqrt(sums[0] * sums[0] + sums[1] * sums[1] + sums[2] * sums[2]);
    for (int i = 0; i < 3; ++i) out[i] = length > 0 ? float(sums[i] / length) : 0.f;
}

void AddShadingNormal(const AovSample& s, double* terms) {
    SetTo(terms, Normalize(s.outputFromRender.Normal(s.hit.ns)));
}

void AddNormal(const AovSample& s, double* terms) {
    SetTo(terms, Normalize(s.outputFromRender.Normal(s.hit.n)));
}

void AddPosition(const AovSample& s, double* terms) { SetTo(terms, s.outputFromRender.Point(s.hit.p)); }

void AddDepth(const AovSample& s, double* terms) { terms[0] = double(s.cameraFromRender.Point(s.hit.p).z); }

void AddUv(const AovSample& s, double* terms) {
    terms[0] = double(s.hit.uv.x);
    terms[1] = double(s.hit.uv.y);
}

void AddSlope(const AovSample& s, double* terms) {
    terms[0] = double(s.outputFromRender.Vector(s.hit.dpdx).z);
    terms[1] = double(s.outputFromRender.Vector(s.hit.dpdy).z);
}

void DevelopSlope(const ColorSpace& color, const AovCounts& counts, const double* sums, float* out) {
    MeanOverHits<2>(color, counts, sums, out);
    for (int i = 0; i < 2; ++i) out[i] = std::abs(out[i]);
}

template <void (*add)(const AovSample&, double*)>
AovOutput NormalOutput(const char* x, const char* y, const char* z) {
    return {.channels = {x, y, z}, .numSums = 3, .needs = {.any = true}, .add = add, .develop = Direction};
}

/// A mean of as many sums as there are channels, in full precision.
template <int n>
AovOutput MeanOutput(const std::vector<std::string>& channels, void (*add)(const AovSample&, double*)) {
    return {.channels = channels,
            .numSums = n,
            .needsFloats = true,
            .needs = {.any = true},
            .add = add,
            .develop = MeanOverHits<n>};
}

AovOutput Normal() { return NormalOutput<AddShadingNormal>("Ns.X", "Ns.Y", "Ns.Z"); }
AovOutput GeometricNormal() { return NormalOutput<AddNormal>("N.X", "N.Y", "N.Z"); }
AovOutput Position() { return MeanOutput<3>({"P.X", "P.Y", "P.Z"}, AddPosition); }
AovOutput Depth() { return MeanOutput<1>({"Z"}, AddDepth); }
AovOutput Uv() { return MeanOutput<2>({"u", "v"}, AddUv); }
AovOutput Slope() {
    AovOutput output = MeanOutput<2>({"dzdx", "dzdy"}, AddSlope);
    output.needs.slopes = true;
    output.develop = DevelopSlope;
    output.isInternal = true;
    return output;
}

}  // namespace

LACQUER_REGISTER(AovKind, "normal", Normal);
LACQUER_REGISTER(AovKind, "ng", GeometricNormal);
LACQUER_REGISTER(AovKind, "position", Position);
LACQUER_REGISTER(AovKind, "depth", Depth);
LACQUER_REGISTER(AovKind, "uv", Uv);
LACQUER_REGISTER(AovKind, "slope", Slope);

}  // namespace lacquer
