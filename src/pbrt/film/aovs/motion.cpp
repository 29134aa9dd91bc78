// Auxiliary output "motion": displacement on the image while the shutter is open, right and up [pixels]. The
// mean over the samples that hit something; where none does, of what is infinitely far.
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

// Sums: x, y and the number of samples; of hits first, then of misses.
void AddMotion(const AovSample& s, double* terms) {
    if (!s.hit.motion) return;
    if (!s.hit.hit) terms += 3;
    terms[0] = double(s.hit.motion->x);
    terms[1] = double(s.hit.motion->y);
    terms[2] = 1;
}

void DevelopMotion(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    if (counts.hits == 0) sums += 3;
    for (int i = 0; i < 2; ++i) out[i] = sums[2] > 0 ? float(sums[i] / sums[2]) : 0.f;
}

AovOutput Motion() {
    return {.channels = {"motion.X", "motion.Y"},
            .numSums = 6,
            .needsFloats = true,
            .needs = {.motion = true},
            .add = AddMotion,
            .develop = DevelopMotion};
}

}  // namespace

LACQUER_REGISTER(AovKind, "motion", Motion);

}  // namespace lacquer
