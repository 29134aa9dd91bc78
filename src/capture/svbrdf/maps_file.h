// Maps as files: linear ones for renderers, and encoded ones as the published code has them.
#pragma once

#include <string>

#include "capture/maps.h"

namespace lacquer::capture {

/// Writes into `directory`, which must exist, files of 32-bit floats: albedo.exr and specular.exr (linear),
/// alpha.exr (of GGX; one channel), normal.exr ((n + 1) / 2). Each file appears as a whole, under its name at
/// the end. Errors: FileError.
void WriteLinearMaps(const Maps& maps, const std::string& directory);
/// Reads these files. Errors: FileError if one cannot be opened; SceneError with the file as its place for
/// images that are no squares or of several sizes, channels that lack, and values beyond [0,1].
Maps ReadLinearMaps(const std::string& directory);

/// Writes dif.png, nom.png, rgh.png and spe.png for exchange with the published code: stored values as [0,1],
/// normals (n + 1) / 2, bytes cut off rather than rounded. Errors: FileError.
void WriteEncodedMaps(const Maps& maps, const std::string& directory);
/// Reads them, in 8 or 16 bits. Errors: as ReadLinearMaps().
Maps ReadEncodedMaps(const std::string& directory);

}  // namespace lacquer::capture
