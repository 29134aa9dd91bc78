#include "pbrt/media/microflakes.h"

#include "pbrt/core/sampling.h"

namespace lacquer {
namespace {

Frame FrameAlong(Vec3 axis) {
    const float length = Length(axis);
    return length > 0 && std::isfinite(length) ? Frame::FromZ(axis / length) : Frame{};
}

// The normal that mirrors wo into wi. Light that goes straight on only grazes flakes; any that contains the
// direction will do there.
Vec3 HalfVector(Vec3 wo, Vec3 wi) {
    const Vec3 h = wo + wi;
    if (LengthSquared(h) > 0) return Normalize(h);
    Vec3 x, y;
    CoordinateSystem(wo, &x, &y);
    return x;
}

// The end of both Sample(): asking anew costs a few ns and gives what a later query will give.
PhaseSample Record(const PhaseFunction& phase, Vec3 wo, Vec3 wi) {
    const PhaseValue value = phase.Evaluate(wo, wi);
    return {wi, 1, value.pdf, value.pdfReverse};
}

// Mirror direction; its length must not drift in long walks.
Vec3 Mirror(Vec3 wo, Vec3 m) { return Normalize(2 * Dot(wo, m) * m - wo); }

}  // namespace

SggxPhase::SggxPhase(Vec3 orientation, float roughness, bool isSurface) : frame_(FrameAlong(orientation)) {
    const float r = roughness < 1 ? std::max(roughness, kMinRoughness) : 1.f;
    across_ = isSurface ? r : 1.f;
    along_ = isSurface ? 1.f : r;
}

float SggxPhase::LocalExtinction(Vec3 w) const {
    // [Heitz et al. 2015]: the projected area of an ellipsoid.
    return std::sqrt(Sqr(across_) * (w.x * w.x + w.y * w.y) + Sqr(along_ * w.z));
}

PhaseValue SggxPhase::LocalEvaluate(Vec3 wo, Vec3 wi) const {
    // D(h) = 1 / (pi sqrt|S| (h^T S^-1 h)^2).
    const Vec3 h = HalfVector(wo, wi);
    const float form = (h.x * h.x + h.y * h.y) / Sqr(across_) + Sqr(h.z / along_);
    const float quarter = 0.25f * InvPi / (Sqr(across_) * along_ * Sqr(form));
    const float forward = quarter / LocalExtinction(wo);
    return {forward, forward, quarter / LocalExtinction(wi)};
}

PhaseValue SggxPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    return LocalEvaluate(frame_.ToLocal(wo), frame_.ToLocal(wi));
}

float SggxPhase::Extinction(Vec3 w) const { return LocalExtinction(frame_.ToLocal(w)); }

PhaseSample SggxPhase::Sample(Vec3 wo, Rng& rng) const {
    // The flakes are the surface of an ellipsoid with half axes proportional to 1/across, 1/across, 1/along.
    // The linear map that makes it a sphere keeps shares of projected area, so what wo sees of it is a
    // uniform disk there, which lifts to a cosine distribution of normals; normals map back by the inverse
    // transpose.
    const Vec3 wo_l = frame_.ToLocal(wo), scale(across_, across_, along_);
    const Vec3 onSphere =
        Frame::FromZ(Normalize(scale * wo_l)).FromLocal(SampleCosineHemisphere(rng.Uniform2D()));
    const Vec3 wi_l = Mirror(wo_l, Normalize(scale * onSphere));
    return Record(*this, wo, frame_.FromLocal(wi_l));
}

FibrePhase::FibrePhase(Vec3 orientation, float stddev)
    : frame_(FrameAlong(orientation)), extinction_(stddev), exponent_(0.5f / Sqr(extinction_.Stddev())) {}

PhaseValue FibrePhase::LocalEvaluate(Vec3 wo, Vec3 wi) const {
    // A flake is met with the density |wo.m| D(m) / sigma over the sphere, so twice that over the normals on
    // the side of wo, and the mirror direction moves over 4 |wo.m| times the solid angle.
    // Denormal numbers would only be slow, so D ends at exp(-80).
    const float exponent = std::min(exponent_ * Sqr(HalfVector(wo, wi).z), 80.f);
    const float half = 0.5f * extinction_.Normalization() * std::exp(-exponent);
    const float forward = half / LocalExtinction(wo);
    return {forward, forward, half / LocalExtinction(wi)};
}

PhaseValue FibrePhase::Evaluate(Vec3 wo, Vec3 wi) const {
    return LocalEvaluate(frame_.ToLocal(wo), frame_.ToLocal(wi));
}

float FibrePhase::Extinction(Vec3 w) const { return LocalExtinction(frame_.ToLocal(w)); }

float FibrePhase::SampleCosineAlong(Rng& rng) const {
    return SafeSqrt(-std::log1p(rng.Uniform() * std::expm1(-exponent_)) / exponent_);
}

float FibrePhase::SampleCosineAcross(Rng& rng) const {
    for (;;) {
        if (exponent_ > 1.5f) {
            // Thin: a Gaussian, then the factor sqrt(1 - z^2).
            const float radius2 = -std::log1p(-rng.Uniform()) / exponent_;
            const float z = std::sqrt(radius2) * std::abs(std::cos(2 * Pi * rng.Uniform()));
            if (z < 1 && Sqr(rng.Uniform()) <= 1 - z * z) return z;
        } else {
            // Wide: a coordinate of a uniform point of the disk has the factor, then the Gaussian.
            const float z = std::abs(SampleUniformDiskConcentric(rng.Uniform2D()).x);
            if (rng.Uniform() <= std::exp(-exponent_ * z * z)) return z;
        }
    }
}

Vec3 FibrePhase::SampleVisibleFlake(Vec3 wo, Rng& rng) const {
    const float sinTheta = std::sqrt(wo.x * wo.x + wo.y * wo.y), cosTheta = std::abs(wo.z);
    const Vec2 azimuth = sinTheta > 0 ? Vec2(wo.x, wo.y) / sinTheta : Vec2(1, 0);
    const float along = cosTheta * extinction_.Along(), across = sinTheta * extinction_.Across();

    // |wo.m| is at most |cosTheta z| + |sinTheta sqrt(1 - z^2) cos phi|. Each of the two, times D, is drawn
    // exactly; of what they draw together at least half is accepted, for the parts have random signs and the
    // mean absolute value of the sum is not below that of either.
    for (;;) {
        float z, cosPhi;
        if (rng.Uniform() * (along + across) < along) {
            z = SampleCosineAlong(rng);
            cosPhi = std::cos(2 * Pi * rng.Uniform());
        } else {
            z = SampleCosineAcross(rng);
            cosPhi = SafeSqrt(1 - Sqr(2 * rng.Uniform() - 1));
        }
        z = std::min(z, 1.f);
        const uint64_t signs = rng.NextBits();
        const float radius = SafeSqrt(1 - z * z), sinPhi = SafeSqrt(1 - cosPhi * cosPhi);
        const float a = cosTheta * z, b = sinTheta * radius * std::abs(cosPhi);
        const bool isOpposite = signs >> 63;
        // Written so that it ends with NaN, too.
        if (isOpposite && rng.Uniform() * (a + b) > std::abs(a - b)) continue;

        // m and -m are one flake, so only the relative signs matter.
        const float c = std::abs(cosPhi) * (isOpposite ? -1.f : 1.f),
                    s = (signs >> 62 & 1) ? -sinPhi : sinPhi;
        return {radius * (azimuth.x * c - azimuth.y * s), radius * (azimuth.y * c + azimuth.x * s),
                std::copysign(z, wo.z)};
    }
}

PhaseSample FibrePhase::Sample(Vec3 wo, Rng& rng) const {
    const Vec3 wo_l = frame_.ToLocal(wo);
    const Vec3 wi_l = Mirror(wo_l, SampleVisibleFlake(wo_l, rng));
    return Record(*this, wo, frame_.FromLocal(wi_l));
}

}  // namespace lacquer
