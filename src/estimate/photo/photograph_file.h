// Photographs as files have them, made ready for the models: a square of linear values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "estimate/photo/flash_photo.h"
#include "pbrt/image/image.h"

namespace lacquer::estimate {

/// Which part of the file is the photograph, and how its values became those of the file.
struct PhotographReading {
    /// Decodes the values of the file. Files of floats are linear whatever it is.
    ColorEncoding tone = {ColorEncoding::Kind::SRGB, 1};
    int resolution = 256;  ///< pixels along a side, at most; a multiple of 16, as the result's are
    /// Pixels along a side at which photographs can be simulated, at most, before they are averaged.
    int simulatedResolution = 512;
    /// Pixels of the file, a square; else the largest one at its centre.
    std::optional<Bounds2i> crop;
};

struct PhotographFile {
    PlanarImage linear;  ///< in [0,1]
    /// Each pixel is the mean of so many times so many of the file's, or of those of the file made smaller to
    /// what can be simulated: simulations have to do the same (PhotoSettings::averaging).
    int averaging = 1;
    Int2 fileResolution{0};
    Bounds2i crop;       ///< the pixels of the file that were taken
    double clipped = 0;  ///< share of the pixels with a channel at its largest value
    double black = 0;    ///< share of those with nothing in any channel
    double fieldOfView =
        0;  ///< across the crop [degrees], by the focal length that the file tells; 0 if it does not
    /// Each a sentence without its full stop; warnings are of what makes the results wrong or vague.
    std::vector<std::string> notes, warnings;
};

inline constexpr int kMinPhotographSide = 64;
/// Share of clipped pixels from which on there is a warning, and from which on there is no point.
inline constexpr double kManyClipped = 0.2, kTooManyClipped = 0.8;

/// Reads any image that the renderer reads, cuts out the square and makes it smaller by means of linear
/// values. Errors: FileError if it cannot be opened; SceneError with the file as its place: no image, values
/// that are negative or no numbers, transparent pixels, channels that are no colours, too few pixels, a crop
/// that is no square inside of the image, nearly all of it clipped.
PhotographFile ReadPhotograph(const std::string& path, const PhotographReading& reading);

}  // namespace lacquer::estimate
