// Where on the film a camera sample lies, and what else of it is drawn before there is a ray.
#pragma once

#include "pbrt/base/camera.h"
#include "pbrt/base/film.h"
#include "pbrt/base/sampler.h"
#include "pbrt/film/estimate_xyz.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

/// What is not drawn: film samples at pixel centres, the lens centre and the middle of the shutter without
/// `pixels`; the same wavelengths for every sample without `wavelengths`.
struct Jitter {
    bool pixels = true, wavelengths = true;
};

/// Which numbers of a camera sample make a difference. Others stay in the middle, and only their dimensions
/// are taken.
struct CameraNumbers {
    explicit CameraNumbers(const Scene& scene) : time(scene.IsMoving()), lens(scene.Camera().ReadsLens()) {}
    bool time, lens;
};

struct FilmSample {
    CameraSample camera;
    SampledWavelengths lambda;
    float weight = 1;  ///< of the filter
};

/// By the dimensions of the sampler from the first one on: film position by the filter, then wavelengths,
/// time and lens.
inline FilmSample SampleFilm(const Film& film, Int2 pixel, const Jitter& jitter, CameraNumbers numbers,
                             Sampler& sampler) {
    const Point2 uFilter = sampler.GetPixel2D();
    const float uLambda = sampler.Get1D();
    CameraSample camera;
    camera.time = 0.5f;
    if (numbers.time && jitter.pixels)
        camera.time = sampler.Get1D();
    else
        sampler.Skip1D();
    if (numbers.lens && jitter.pixels)
        camera.pLens = sampler.Get2D();
    else
        sampler.Skip2D();
    const FilterSample filter = jitter.pixels ? film.Filter().Sample(uFilter) : FilterSample{Point2(0), 1};
    camera.pFilm = Point2(pixel) + filter.offset + Point2(0.5f);
    return {camera, film.SampleWavelengths(jitter.wavelengths ? uLambda : 0.5f), filter.weight};
}

/// What a sample adds to its pixel, limited as the film limits it; zero where it is no number.
inline XYZ XYZOf(const FilmSample& sample, SampledSpectrum L, const Film& film) {
    constexpr float kMaxValue = 1e15f;  // so that squares can be summed
    if (!L.IsValid()) return XYZ(0);
    const XYZ xyz = EstimateXYZ(L, sample.lambda) * (sample.weight * film.LimitOf(L, sample.lambda));
    return IsFinite(xyz) ? glm::clamp(xyz, -kMaxValue, kMaxValue) : XYZ(0);
}

}  // namespace lacquer
