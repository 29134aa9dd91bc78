// Phase function "sggx": microflakes with the normals of an ellipsoid.
//
//   "vector3 orientation"     0 0 1  of fibres, or normal of sheets; in slabs x is the tangent, in media the
//                                    axes are those of the medium
//   "string orientationmap"   -      in slabs, an image of it, 2c-1, as a normal map
//   "float roughness"         0.1    in [0, 1]; 1: flakes of all directions; a texture in slabs
//   "string flakes"           fibre  or "surface"
#include "pbrt/phases/sggx.h"

#include "pbrt/phases/microflakes.h"
#include "pbrt/phases/orientation.h"

namespace lacquer {

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
    return PhaseRecord(*this, wo, frame_.FromLocal(wi_l));
}

namespace {

class SggxModel final : public PhaseModel {
  public:
    SggxModel(Orientation orientation, PhaseNumber roughness, bool isSurface)
        : orientation_(std::move(orientation)), roughness_(roughness), isSurface_(isSurface) {}
    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<SggxPhase>(orientation_.At(context), roughness_.At(context), isSurface_);
    }
    bool IsOriented() const override { return true; }
    bool IsConstant() const override { return orientation_.IsConstant() && roughness_.Constant(); }

  private:
    Orientation orientation_;
    PhaseNumber roughness_;
    bool isSurface_;
};

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    return std::make_unique<SggxModel>(
        Orientation::Read(args), ReadPhaseNumber(args, "roughness", 0.1f, 0, 1),
        args.params.GetChoice("flakes", "fibre", {"fibre", "surface"}) == "surface");
}

constexpr std::string_view kParameters[] = {Orientation::kParameter, Orientation::kMapParameter, "roughness",
                                            "flakes"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "sggx", &kPlugin);

}  // namespace lacquer
