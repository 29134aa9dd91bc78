// views.json: photographs with what is known of them, and the photographs themselves.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture/svbrdf/rectified_image.h"
#include "capture/views.h"

namespace lacquer::capture {

/// Reads a file of at most 16 MB:
///
///     {"unit": "cm", "size": 10.88, "response": "gamma2.2", "lightPower": [1500, 1500, 1500],
///      "views": [{"image": "00.png", "camera": [0, 0, 25], "light": [0, 0, 25], "use": "fit"}, ...]}
///
/// "response" is "gamma2.2" (default), "srgb" or "linear"; "use" is "fit" (default) or "test"; without
/// "light" it is at the camera; "unit" and "lightPower" may be left out. Or, by the names of the published
/// code, "im_size", "camera_pos", "light_pos" (by default the cameras), "light_pow" (one number or three),
/// and "idx", the views that count, whose images are 00.png, 01.png, ... Errors: FileError if it cannot be
/// read; SceneError with line and column for all else, among it cameras and lights that are not above the
/// sample.
ViewSet ReadViews(const std::string& path);
/// The same of a text. @param path  for messages
ViewSet ParseViews(std::string_view text, const std::string& path);

/// Writes our form. Errors: FileError.
void WriteViews(const ViewSet& views, const std::string& path);

/// Reads a square image and makes it smaller by means of linear values. @param size  above 0
/// Errors: FileError if it cannot be opened; SceneError with the file as its place if it is no image, no
/// square, smaller than `size`, has other channels than R, G and B or one alone, or values that are negative
/// or no numbers.
RectifiedImage ReadRectifiedImage(const std::string& path, Response response, int size);

/// The images of all views. @param directory  of the views, where relative names begin
std::vector<RectifiedImage> ReadViewImages(const ViewSet& views, const std::string& directory, int size);

}  // namespace lacquer::capture
