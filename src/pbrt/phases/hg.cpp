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
