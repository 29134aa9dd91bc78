// Auxiliary output "example": the share of samples that hit something.
// Stands in src/pbrt/film. Run: scene.pbrt --quiet --aov example
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

void Add(const AovSample&, double*) {}

void Develop(const ColorSpace&, const AovCounts& counts, const double*, float* out) {
    out[0] = float(counts.hits / counts.samples);
}

AovOutput Example() {
    return {.channels = {"Example.V"}, .needs = {.any = true}, .add = Add, .develop = Develop};
}

}  // namespace

LACQUER_REGISTER(AovKind, "example", Example);

}  // namespace lacquer
