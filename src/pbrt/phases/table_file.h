// Files of phase functions.
#pragma once

#include "pbrt/core/error.h"
#include "pbrt/phases/table.h"

namespace lacquer {

/// Reads a text file; '#' starts a comment that ends with its line:
///     wavelengths 450 550 650      [nm], increasing; without this line the function is the same at all
///     0    12.1 11.4 10.2          an angle [degrees], then the value at each wavelength, in any unit
///     ...                          angles increase, the first one is 0 (straight on)
///     180   0.1  0.1  0.1          and the last one 180
/// Errors: FileError at `loc` if it cannot be read; SceneError with the place in the file for what is no such
/// table: no numbers, rows of different lengths, angles or wavelengths out of order, negative values, a
/// wavelength at which all are 0, a lobe that is too narrow (WhyTooNarrow).
PhaseNumbers ReadPhaseTableFile(const std::string& path, const FileLoc& loc);

}  // namespace lacquer
