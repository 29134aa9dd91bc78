// Phase function "hg": that of Henyey and Greenstein.
//
//   "float g"  0  mean cosine of the scattering angle, in [-1, 1]; a texture in slabs; media clamp it to
//                 [-0.99, 0.99], as pbrt
#include "pbrt/phases/hg.h"

#include "pbrt/phases/angular.h"

namespace lacquer {

HenyeyGreensteinPhase::HenyeyGreensteinPhase(float g)
    : absG_(std::min(std::abs(g), kMaxG)), isForward_(!(g < 0)) {
    if (std::isnan(g)) absG_ = 0;
}

PhaseValue HenyeyGreensteinPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    // 1 + g^2 - 2 |g| cos about the axis of the lobe, without cancellation.
    const float d = Sqr(1 - absG_) + 2 * absG_ * OneMinusCos(Axis(wo), wi);
    return SymmetricPhase(Inv4Pi * (1 - absG_) * (1 + absG_) / (d * std::sqrt(d)));
}

PhaseSample HenyeyGreensteinPhase::Sample(Vec3 wo, Rng& rng) const {
    // The textbook inverse of the distribution function has 1/g; solved for 1 - cos it has not, and holds at
    // g = 0 as it stands.
    const Point2 u = rng.Uniform2D();
    const float a = absG_, b = 1 - a + 2 * a * (1 - u.x);
    const float oneMinusCos = 2 * Sqr((1 - a) / b) * u.x * (1 + a - a * u.x);
    return PhaseRecord(*this, wo, AroundAxis(Axis(wo), std::min(oneMinusCos, 2.f), u.y));
}

std::unique_ptr<PhaseModel> MakeHenyeyGreensteinPhaseModel(const FloatTexture* g) {
    return std::make_unique<AngularPhaseModel<HenyeyGreensteinPhase>>(PhaseNumber(g));
}

namespace {

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    using Model = AngularPhaseModel<HenyeyGreensteinPhase>;
    if (args.owner.Textures()) return std::make_unique<Model>(ReadPhaseNumber(args, "g", 0, -1, 1));
    // Media are pbrt's.
    constexpr float kMaxG = 0.99f;
    RefuseTexture(args, "g");
    return std::make_unique<Model>(PhaseNumber(std::clamp(args.params.GetFloat("g", 0), -kMaxG, kMaxG)));
}

constexpr std::string_view kParameters[] = {"g"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "hg", &kPlugin);

}  // namespace lacquer
