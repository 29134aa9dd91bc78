// Phase function "fibre": microflakes around fibres.
//
//   "vector3 orientation", "string orientationmap": as for "sggx"
//   "float stddev"  0.1  of the cosine between the flakes' normals and the fibre, > 0; a texture in slabs
#include "pbrt/phases/fibre.h"

#include "pbrt/phases/microflakes.h"
#include "pbrt/phases/orientation.h"

namespace lacquer {

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
    return PhaseRecord(*this, wo, frame_.FromLocal(wi_l));
}

namespace {

class FibreModel final : public PhaseModel {
  public:
    FibreModel(Orientation orientation, PhaseNumber stddev)
        : orientation_(std::move(orientation)), stddev_(stddev) {}
    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<FibrePhase>(orientation_.At(context), stddev_.At(context));
    }
    bool IsOriented() const override { return true; }
    bool IsConstant() const override { return orientation_.IsConstant() && stddev_.Constant(); }

  private:
    Orientation orientation_;
    PhaseNumber stddev_;
};

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    const PhaseNumber stddev = ReadPhaseNumber(args, "stddev", 0.1f, 0, Infinity);
    if (stddev.Constant() == 0.f)
        args.params.Fail("stddev", "\"stddev\" is 0; expected a positive standard deviation");
    return std::make_unique<FibreModel>(Orientation::Read(args), stddev);
}

constexpr std::string_view kParameters[] = {Orientation::kParameter, Orientation::kMapParameter, "stddev"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "fibre", &kPlugin);

}  // namespace lacquer
