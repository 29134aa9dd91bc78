// Scenes from text, rendered: as an image, or as radiance in units of white.
#pragma once

#include "pbrt/image/image.h"
#include "pbrt/integrators/render.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::test {

/// Renders all samples of `setup`, or those that `options` ask for, into its film.
inline RenderStats RenderAll(const RenderSetup& setup, RenderOptions options = {}) {
    if (options.endSample == 0) options.endSample = setup.sampler->SamplesPerPixel();
    options.seed = setup.generatorSeed;
    Observer silent;
    return Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, silent);
}
inline std::unique_ptr<Image> RenderText(const std::string& text) {
    const RenderSetup setup = BuildText(text);
    RenderAll(setup);
    return setup.film->Develop();
}
inline double LuminanceAt(const Image& image, Int2 p) {
    return double(ColorSpace::SRGB().Luminance({image.Get(p, 0), image.Get(p, 1), image.Get(p, 2)}));
}
/// Luminance over the pixels: independent numbers where the sampler is "independent".
inline RunningMean PixelLuminance(const Image& image) {
    RunningMean mean;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x) mean.Add(LuminanceAt(image, {x, y}));
    return mean;
}

/// Radiance along the camera ray through the middle of the image, divided by that of a light `rgb L [1 1 1]`
/// wavelength by wavelength: for grey scenes there is no noise of colour in it.
inline RunningMean CenterRadiance(const RenderSetup& setup, int samples, uint64_t seed = 1) {
    RunningMean mean;
    ThreadState state;
    const auto sampler = setup.sampler->Clone();
    for (int i = 0; i < samples; ++i) {
        sampler->StartPixelSample({int(seed % 1009), int(seed / 1009 % 1009)}, i);
        state.rng = Rng(Hash(seed, i));
        SampledWavelengths lambda = SampledWavelengths::SampleVisible(sampler->Get1D());
        const auto ray =
            setup.scene->Camera().GenerateRay({Point2(setup.scene->Resolution()) / 2.f, Point2(0.5f), 0.5f});
        const SampledSpectrum L = setup.integrator->Li(*ray, lambda, *sampler, state);
        const SampledSpectrum white = SafeDivide(L, ColorSpace::SRGB().Illuminant().Sample(lambda));
        const float value = lambda.SecondaryTerminated() ? white[0] : white.Average();
        mean.Add(double(value * kCieYIntegral));
        state.arena.Reset();
    }
    return mean;
}

}  // namespace lacquer::test
