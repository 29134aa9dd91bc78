// Photographs of a sample as seen from straight above.
#pragma once

#include <span>

#include "capture/card/camera_model.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {

struct RectifyOptions {
    double squareSize = 10.88;  ///< edge of the square of the sample [cm]
    double depth = 0.1;         ///< of the sample below the card [cm]
    int resolution = 256;       ///< pixels along an edge
    float clipped = 1;          ///< linear values from here on are clipped
};

struct RectifiedPhotograph {
    /// Linear R, G, B. Pixel (row i, column j) of R x R is around x = ((j+1/2)/R - 1/2) squareSize,
    /// y = -((i+1/2)/R - 1/2) squareSize of the sample.
    Image linear;
    double clippedShare = 0;  ///< of pixels that a clipped value is in
    double outsideShare = 0;  ///< of pixels that the photograph does not show; they continue its border
};

/// Resamples once, from the photograph to the square: each pixel is the mean of the photograph over the
/// pixel's own area, at as many points as the photograph has pixels there, each interpolated by the cubic of
/// [Keys 1981]. So where the square has more pixels it is an interpolation, where it has fewer a box filter
/// over what they cover, which is what pixels are in the model of the fit. Means are of light: of encoded
/// values they would be those of another, darker light, at edges and in highlights.
/// @param linear  R, G, B
RectifiedPhotograph Rectify(const Image& linear, const Intrinsics& intrinsics, const CameraPose& pose,
                            const RectifyOptions& options);

/// Pixels of the photograph along an edge of the square, as the root of its area: for the one of the poses
/// that has the fewest.
double PixelsAcross(const Intrinsics& intrinsics, std::span<const CameraPose> poses, double squareSize,
                    double depth);

}  // namespace lacquer::capture
