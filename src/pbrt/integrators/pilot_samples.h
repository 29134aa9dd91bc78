// The samples by which adaptive sampling is planned.
#pragma once

#include "pbrt/core/progress.h"
#include "pbrt/integrators/film_sample.h"
#include "pbrt/integrators/sample_shares.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

struct PilotOptions {
    int samples = 0;  ///< of a pixel of the render on average: PilotPlanOf()
    int seed = 0;
    Jitter jitter;
};

/// Few pixels with many pilots, rather than a few pilots in each pixel: one sample tells how much samples
/// differ, and where they are well distributed that is not the error that is left of many.
struct PilotPlan {
    int spacing = 1;  ///< one pixel of each spacing x spacing has pilots,
    int half = 1;     ///< this many in each of two estimates
};
/// For a render of so many samples: about 1/32 of them, and 8 for each pixel at most.
PilotPlan PilotPlanOf(int samples);

/// Takes pilots of the film and divides the samples by them: SharesByPilots(). A pixel with pilots, anywhere
/// in its block, has two independent estimates, each from a low-discrepancy set of its own, so that their
/// difference tells the error that is left where points are well distributed and not that of independent
/// samples.
///
/// The pilots have random numbers of their own and are part of no image, so that shares and samples are
/// independent and every pixel stays unbiased. They do not depend on threads. If the observer stops them all
/// pixels get the same share. The integrator MakesSplats() not.
SampleShares MeasureShares(const Scene& scene, const Integrator& integrator, const Film& film,
                           const PilotOptions& options, Observer& observer);

}  // namespace lacquer
