// From photographs of a card on a sample to rectified images with their cameras and lights.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/card/calibration.h"
#include "capture/card/card.h"
#include "capture/views.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {

struct CaptureOptions {
    double size = 17;    ///< of the card: outer edge of the square of tags [cm]
    double depth = 0.1;  ///< of the sample below the card's face [cm]
    /// Edge of the square of the sample in the middle, in sizes of the card.
    double sampleShare = kSampleShare;
    Response response = Response::Gamma22;
    int resolution = 256;              ///< of rectified images, pixels along an edge
    std::optional<double> focal = {};  ///< focal length, if it is known [pixels]
    /// Where the flash is, in the frame of the camera as pbrt has it [cm]: x to the right, y up, z in the
    /// direction of view; of the pixels as the file stores them, for a phone held upright is one on its side.
    Point flash{};
};

/// One photograph, with what a report shows of it.
struct CapturedPhotograph {
    std::string file;
    TagDetection detection;     ///< tags as they were seen
    PhotographPose pose;        ///< in the frame of the card: of its face, not of the sample
    double exposureFactor = 1;  ///< that linear values were multiplied with, for all to have one exposure
    double clippedShare = 0;    ///< of the square of the sample that has a clipped value
    double outsideShare = 0;    ///< of the square that the photograph does not show
    Image rectified;            ///< linear R, G, B; rows and columns as Rectify() has them
};

struct CapturedPhotographs {
    /// In the order of the files. The frame is that of the card, moved to the sample, whose plane is z = 0.
    /// Images are named 00.png, 01.png, ..., or .exr if the response is linear: WriteRectified() makes them.
    ViewSet views;
    Int2 resolution{0};       ///< of the photographs
    Calibration calibration;  ///< its warnings are among those below
    std::vector<CapturedPhotograph> photographs;
    /// Pixels that photographs have along an edge of the square, the fewest of all: more than so many show
    /// nothing new.
    double pixelsAcross = 0;
    std::vector<std::string> notes, warnings;  ///< each a sentence without its full stop
};

/// Reads, detects, calibrates and rectifies; photographs side by side, with one result for any number of
/// threads. Each file is read twice: the pixels of nine photographs at once would take gigabytes.
///
/// Warnings, beside those of Calibrate(): more than 5 % of the sample clipped, parts of it outside of a
/// photograph, more pixels asked for than photographs have, different focal lengths in the metadata,
/// exposures that only some files tell. Notes: exposures that were divided out, those of the brightest by as
/// much as it takes to equal the darkest, so that nothing is clipped by that. Errors: those of Calibrate(),
/// SceneErrors for all files that cannot be read, are given twice or are of another size than the first one,
/// SceneError for a flash that is not above the sample,
/// std::invalid_argument for sizes and resolutions out of bounds.
CapturedPhotographs CapturePhotographs(const std::vector<std::string>& files, const CaptureOptions& options);

/// Writes the rectified images beside each other as the views name them: codes of the response in 8 bits,
/// with dither of less than half a code, or linear floats. Errors: FileError.
void WriteRectified(const CapturedPhotographs& captured, const std::string& folder);

}  // namespace lacquer::capture
