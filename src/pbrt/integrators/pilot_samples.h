// The samples by which adaptive sampling is planned.
#pragma once

#include "pbrt/core/progress.h"
#include "pbrt/integrators/film_sample.h"
#include "pbrt/integrators/sample_shares.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

struct PilotOptions {
    int samples = 0;  ///< of a pixel of the render on average: pilots are about 1/32 of that
    int seed = 0;
    Jitter jitter;
};

/// Samples of each pixel that are taken as pilots for a render of so many: even, from 2 to 32.
int PilotSamples(int samples);

/// Takes pilots of all pixels of the film and divides the samples by them: SharesByPilots(). Each pixel has
/// two independent estimates, each from a low-discrepancy set of its own, so that their difference tells the
/// error that is left where points are well distributed and not that of independent samples.
///
/// The pilots have random numbers of their own and are part of no image, so that shares and samples are
/// independent and every pixel stays unbiased. They do not depend on threads. If the observer stops them all
/// pixels get the same share. The integrator MakesSplats() not.
SampleShares MeasureShares(const Scene& scene, const Integrator& integrator, const Film& film,
                           const PilotOptions& options, Observer& observer);

}  // namespace lacquer
