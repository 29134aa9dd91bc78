// Auxiliary output "alpha": the part of the camera's light that does not come from behind everything: 1 where
// a sample meets a surface, and what media absorb or scatter. Filtered as colours are.
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

void AddAlpha(const AovSample& s, double* terms) {
    terms[0] = double(s.weight) * (s.hit.hit ? 1 : double(s.hit.coverage));
    terms[1] = double(s.weight);
}

void DevelopAlpha(const ColorSpace&, const AovCounts&, const double* sums, float* out) {
    out[0] = sums[1] != 0 ? float(sums[0] / sums[1]) : 0.f;
}

AovOutput Alpha() {
    return {.channels = {"A"},
            .numSums = 2,
            .needs = {.coverage = true},
            .add = AddAlpha,
            .develop = DevelopAlpha};
}

}  // namespace

LACQUER_REGISTER(AovKind, "alpha", Alpha);

}  // namespace lacquer
