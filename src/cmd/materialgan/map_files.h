// Maps as four images in the convention of published ones.
#pragma once

#include <string>

#include "capture/maps.h"

namespace lacquer::cmd {

/// dif.png, nom.png, rgh.png and spe.png of a folder: numbers as stored, from 0 to 1; of normals (n+1)/2.
/// Errors: FileError for files that lack, are no squares, larger than any generator's maps or not of one
/// size, lack channels, or hold values that are not finite; those of ReadImage.
capture::Maps ReadMapImages(const std::string& folder);
/// Errors: FileError.
void WriteMapImages(const capture::Maps& maps, const std::string& folder);

}  // namespace lacquer::cmd
