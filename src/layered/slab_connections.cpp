#include "layered/slab_connections.h"

namespace lacquer::layered {
namespace {

using Floats = SlabConnections::Floats;
using Ints = SlabConnections::Ints;
constexpr size_t kLanes = SlabConnections::kLanes;

float At(float x, size_t) { return x; }
int At(int x, size_t) { return x; }
float At(const Floats& x, size_t i) { return x[i]; }
int At(const Ints& x, size_t i) { return x[i]; }

/// @tparam kNumExtinctions  1 if that of all wavelengths is the same
template <size_t kNumExtinctions, class Drawn, class Inside>
[[gnu::always_inline]] inline void Connect(const Drawn& d, const Inside& v, const Slab& slab, int maxVertices,
                                           std::array<Floats, kNumWavelengths>& sum) {
    const HenyeyGreensteinPhase phase = *slab.GetHenyeyGreenstein();
    const float side = phase.IsForward() ? -1.f : 1.f;
    std::array<float, kNumExtinctions> thickness;
    for (size_t c = 0; c < kNumExtinctions; ++c) thickness[c] = slab.opticalThickness[int(c)];

    // Each wavelength's transmittance, and Crossing's densities.
    std::array<Floats, kNumExtinctions> transmittance;
    Floats pdfInside, pdfBoundary, scale;
    for (size_t i = 0; i < kLanes; ++i) pdfInside[i] = pdfBoundary[i] = 0;
    for (size_t c = 0; c < kNumExtinctions; ++c)
        for (size_t i = 0; i < kLanes; ++i) {
            const float path = std::abs(At(v.x, i) - At(d.start, i)) * At(d.extinction, i);
            const float t = Exp(-thickness[c] * path);
            transmittance[c][i] = t;
            pdfInside[i] += thickness[c] * At(d.extinction, i) * t * (1.f / kNumExtinctions);
            pdfBoundary[i] += t * (1.f / kNumExtinctions);
        }

    for (size_t i = 0; i < kLanes; ++i) {
        const float x = At(d.wx, i) + side * At(v.wx, i), y = At(d.wy, i) + side * At(v.wy, i),
                    z = At(d.wz, i) + side * At(v.wz, i);
        const float p = phase.ValueAt(0.5f * (x * x + y * y + z * z));
        const float own = At(d.pdf, i), inside = pdfInside[i];
        const float ofReverse = At(d.startsInside, i) > 0 ? inside : pdfBoundary[i];
        const float all = At(v.ownTerm, i) + p * At(v.otherTerm, i);
        constexpr float kMax = std::numeric_limits<float>::max();
        const float shorter = all < kMax ? all : kMax;
        const float others =
            p * (At(d.otherSamples, i) + ofReverse * At(d.shorter, i)) + own * inside * shorter;
        scale[i] = own / (own + others) * p * At(d.extinction, i);
    }
    for (size_t i = 0; i < kLanes; ++i) {
        const float dx = At(v.x, i) - At(d.start, i);
        const int isElsewhere = At(d.slab, i) ^ At(v.slab, i);
        const int room = maxVertices - At(d.count, i) - At(v.count, i);
        const float there = isElsewhere == 0 ? scale[i] : 0.f;
        const float ahead = dx * At(d.wz, i) < 0 ? there : 0.f;
        scale[i] = room >= 0 ? ahead : 0.f;
    }
    for (size_t i = 0; i < kLanes; ++i)
        for (size_t c = 0; c < kNumWavelengths; ++c)
            sum[c][i] += At(d.beta[c], i) * At(v.beta[c], i) *
                         (scale[i] * transmittance[kNumExtinctions == 1 ? 0 : c][i]);
}

}  // namespace

[[gnu::flatten]] void SlabConnections::ConnectTo(const Vertex& light, const Slab& slab, int maxVertices) {
    if (slab.IsGray())
        Connect<1>(drawn_, light, slab, maxVertices, sum_);
    else
        Connect<kNumWavelengths>(drawn_, light, slab, maxVertices, sum_);
}

[[gnu::flatten]] void SlabConnections::ConnectFrom(const Direction& light, const Slab& slab,
                                                   int maxVertices) {
    if (slab.IsGray())
        Connect<1>(light, inside_, slab, maxVertices, sum_);
    else
        Connect<kNumWavelengths>(light, inside_, slab, maxVertices, sum_);
}

}  // namespace lacquer::layered
