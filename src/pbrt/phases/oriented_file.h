// Files of oriented ensembles: a JSON text and an image beside it (docs/bulk.md).
#pragma once

#include <string>

#include "pbrt/scattering/bulk_table.h"

namespace lacquer {

/// Reads the image of `table`'s phase functions into it: rows are angles of one incidence after the other,
/// columns azimuths, channels "p.550" wavelengths.
/// @param path  of the JSON text, which `table` was read from; @param loc  what names that file
/// Errors: those of ReadImage; SceneError at the image for another size, missing channels, numbers that are
/// negative or not finite, p with integrals other than 1 to within 1e-4, and what is not reciprocal, sigma_s
/// times p of a pair of directions, to within 1e-3.
void ReadOrientedPhase(const std::string& path, const FileLoc& loc, OrientedBulkTable* table);

/// The image beside a JSON text: its path with the extension "exr".
std::string ImageOfOrientedBulk(const std::string& path);
/// Writes both files; `phaseFile` is set to the image's name. The same table gives the same bytes. Errors:
/// FileError.
void WriteOrientedBulk(OrientedBulkTable table, const std::string& path);

}  // namespace lacquer
