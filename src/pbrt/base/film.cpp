#include "pbrt/base/film.h"

namespace lacquer {

void Film::PrepareForSplats(int) {
    throw SceneError({}, "this film cannot take light that is traced from the lights; the \"rgb\" film can");
}

bool Film::AddSplat(Point2, SampledSpectrum, const SampledWavelengths&) { return false; }

}  // namespace lacquer
