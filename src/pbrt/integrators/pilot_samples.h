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

/// A few pilots in every pixel, where there are samples for that: where noise is even, many in few pixels
/// tell as much, but edges and bright spots, which have most of the error of many images, are missed by
/// those.
struct PilotPlan {
    int spacing = 1;  ///< one pixel of each spacing x spacing has pilots,
    int half = 1;     ///< this many in each of two estimates
};
/// For a render of so many samples in each of `pixels`: about 1/32 of all of them, 32 in a pixel at most, in
/// 2.5 million pixels at most (of an image of up to 64 times as many).
PilotPlan PilotPlanOf(int samples, int64_t pixels);

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
