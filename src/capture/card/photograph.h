// Photographs as files have them: linear values, and what the camera wrote beside them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/views.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {

struct PhotographFile {
    /// R, G, B (equal where the file is grey), decoded by the response. Files of floats, and 16-bit ones of
    /// TIFF, are linear whatever it is. Rows are as stored: the orientation that metadata ask for would turn
    /// the sensor.
    Image linear;
    /// Linear values from here on are clipped.
    float clipped = 1;
    std::optional<double> focal35mm;  ///< focal length as of 35 mm film [mm]
    /// Light that the camera let in, for one of the scene: exposure time [s] times ISO over the square of the
    /// aperture's number. Empty unless the file tells all three.
    std::optional<double> exposure;
};

/// Errors: FileError if it cannot be opened; SceneError with the file as its place: no image, no colours,
/// values that are not finite.
PhotographFile ReadPhotographFile(const std::string& path, Response response);

/// A focal length as of 35 mm film in pixels: the diagonal of the frame counts.
double FocalInPixels(double focal35mm, Int2 resolution);

/// Files of a folder that may be photographs (png, jpg, jpeg, exr, tif, tiff), by name; their paths.
/// Errors: FileError if it cannot be read, or has none.
std::vector<std::string> PhotographsOfFolder(const std::string& folder);

}  // namespace lacquer::capture
