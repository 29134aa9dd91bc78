#include "pbrt/film/first_hit.h"

namespace lacquer {

namespace {

/// The fractional part of x >= 0, below 1 whatever the rounding.
float Fraction(float x) { return std::min(x - std::floor(x), OneMinusEpsilon); }

/// i in base 2, mirrored at the point.
float RadicalInverse2(int i) {
    float inverse = 0;
    for (float digit = 0.5f; i; i >>= 1, digit /= 2) inverse += digit * float(i & 1);
    return inverse;
}

}  // namespace

SampledSpectrum DirectionalAlbedo(const BxDF& bxdf, Vec3 wo, Rng* rng) {
    constexpr int kSamples = 16;
    const float shift[3] = {rng->Uniform(), rng->Uniform(), rng->Uniform()};
    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, rng};
    SampledSpectrum sum(0);
    for (int i = 0; i < kSamples; ++i) {
        const float t = float(i) / kSamples;
        // The lobe's number runs through its 16 strata in another order than x does.
        const BxDFRandom u{Fraction(7 * t + shift[0]),
                           {Fraction(t + shift[1]), Fraction(RadicalInverse2(i) + shift[2])}};
        if (const auto sample = bxdf.Sample(wo, u, context)) sum += sample->weight;
    }
    return sum / float(kSamples);
}

void FirstHitRecorder::Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) {
    last_.hit = true;
    last_.p = si.p;
    last_.n = FaceForward(si.n, si.wo);
    last_.ns = FaceForward(si.shading.n, si.wo);
    last_.uv = si.uv;
    last_.time = si.time;
    last_.object = si.object;
    last_.material = si.material;
    if (!wantAlbedo_) return;
    Rng rng(seed_);
    last_.albedo = DirectionalAlbedo(bxdf, woLocal, &rng);
}

}  // namespace lacquer
