#include "pbrt/film/first_hit.h"

namespace lacquer {

namespace {

/// BxDF samples of an albedo at each hit: those of a pixel together make it smooth.
constexpr int kSamplesPerHit = 1;

/// Coordinate `axis` of point i of a sequence whose every stretch is even in three dimensions: multiples of
/// the powers of 1/g, where g^4 = g + 1 [Roberts 2018].
float SequencePoint(uint32_t i, int axis, uint32_t shift) {
    constexpr uint32_t kSteps[3] = {3518319155u, 2882110345u, 2360945575u};
    return std::min(float(shift + i * kSteps[axis]) * 0x1p-32f, OneMinusEpsilon);
}

}  // namespace

SampledSpectrum DirectionalAlbedo(const BxDF& bxdf, Vec3 wo, uint64_t seed, int first, int count) {
    Rng shifts(seed);
    const uint32_t shift[3] = {uint32_t(shifts.NextBits() >> 32), uint32_t(shifts.NextBits() >> 32),
                               uint32_t(shifts.NextBits() >> 32)};
    Rng rng(Hash(seed, first));
    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, &rng};
    SampledSpectrum sum(0);
    for (int k = first; k < first + count; ++k) {
        const auto i = uint32_t(k);
        const BxDFRandom u{SequencePoint(i, 0, shift[0]),
                           {SequencePoint(i, 1, shift[1]), SequencePoint(i, 2, shift[2])}};
        if (const auto sample = bxdf.Sample(wo, u, context)) sum += sample->weight;
    }
    return sum / float(count);
}

void FirstHitRecorder::Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) {
    last_.hit = true;
    last_.p = si.p;
    last_.n = FaceForward(si.n, si.wo);
    last_.ns = FaceForward(si.shading.n, si.wo);
    last_.uv = si.uv;
    last_.time = si.time;
    last_.object = si.object;
    last_.instance = si.instance;
    last_.material = si.material;
    if (!wantAlbedo_) return;
    last_.albedo = DirectionalAlbedo(bxdf, woLocal, seed_, index_ * kSamplesPerHit, kSamplesPerHit);
}

}  // namespace lacquer
