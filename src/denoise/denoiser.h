// Noise of Monte Carlo renders removed by first-order regression on features, with an estimate of what is
// left [Bitterli et al. 2016, NFOR].
#pragma once

#include "denoise/planes.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/image.h"

namespace lacquer::denoise {

/// What the denoiser needs of a render. Half of the samples of a pixel are in the first half, the others
/// in the second: their noises are independent, or nearly.
struct RenderBuffers {
    Color half[2];
    Color variance;  ///< of a half, estimated: per channel
    Features features;
    Features featureVariances;  ///< estimated
};

/// The buffers of an image with the channels of `--aov half,variance,albedo,normal,depth`.
/// Errors: std::invalid_argument that names what is missing, or says why the image will not do.
RenderBuffers BuffersOf(const Image& image);

struct DenoiseOptions {
    int windowRadius = 9;
    /// Of two candidates; between them and the colours as they are the estimated error decides in each pixel.
    float bandwidths[2] = {0.5f, 1};
    Observer* observer = nullptr;  ///< hears of the progress; may be null
};

struct Denoised {
    Color color;
    /// Variance that is left, the mean of the channels: of how the two halves differ, filtered. What the
    /// filter has blurred (its bias) is not in it.
    Planes<1> noise;
    /// Standard deviation over the whole image, by the halves; too large before where they know of each
    /// other.
    float noiseBefore = 0, noiseAfter = 0;
};
/// The same bits for any number of threads. Cost: about 40 us a pixel of one core.
Denoised Denoise(const RenderBuffers& buffers, const DenoiseOptions& options);

/// Writes colours into the channels R, G and B of an image of the same size.
void SetColors(const Color& color, Image* image);

}  // namespace lacquer::denoise
