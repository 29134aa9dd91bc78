// FLIP: how different two images look to a person who flips between them on a screen.
#pragma once

#include "pbrt/image/image.h"

namespace lacquer::compare {

/// Pixels per degree of vision where the papers look: a screen 0.7 m wide of 3840 pixels, from 0.7 m.
inline constexpr float kFlipPixelsPerDegree = 3840 * Pi / 180;

/// The perceived difference of two images for a screen, [Andersson et al. 2020]: one channel "FLIP", from 0
/// (none) to 1, for each pixel. Not symmetric in general for HdrFlip(), symmetric for this.
/// @param image, reference  R, G and B of one size and colour space, linear and finite; what is outside of
/// [0,1] after conversion to sRGB is cut off
/// Cost: some 1 microsecond a pixel and core. Deterministic.
Image LdrFlip(const Image& image, const Image& reference, float pixelsPerDegree = kFlipPixelsPerDegree);

/// The exposures that HDR-FLIP looks at, in stops; `count` of them in even steps, both ends included.
struct FlipExposures {
    float start = 0, stop = 0;
    int count = 1;
};

/// From the reference's brightest pixel to its median, each brought to 0.85 by the ACES curve
/// [Andersson et al. 2021]; one step for each stop between, at least two. A black reference has exposure 0.
FlipExposures HdrFlipExposures(const Image& reference);

/// The same for images of any range, [Andersson et al. 2021]: the greatest of LdrFlip() over the exposures,
/// each through the ACES curve. Negative values count as black. Cost: that of LdrFlip() for each exposure.
Image HdrFlip(const Image& image, const Image& reference, const FlipExposures& exposures,
              float pixelsPerDegree = kFlipPixelsPerDegree);

}  // namespace lacquer::compare
