// Phase function "example": the same in all directions.
//   numexample    float    1    must not be negative
// Stands in src/pbrt/phases. Scene: MakeNamedMedium "fog" "string type" "homogeneous" "string phase"
// "example"
//                                       "float numexample" 2
#include "pbrt/core/params.h"
#include "pbrt/phases/isotropic.h"

namespace lacquer {
namespace {

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    if (!(args.params.GetFloat("numexample", 1) >= 0)) args.params.Fail("numexample", "must not be negative");
    return MakeIsotropicPhaseModel();
}

constexpr std::string_view kParameters[] = {"numexample"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "example", &kPlugin);

}  // namespace lacquer
