// Files of "lacquer bulk": how a medium of particles scatters, by wavelength. docs/bulk.md describes them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pbrt/core/error.h"

namespace lacquer {

/// What such a file says of an isotropic medium. Lengths in mm, p in 1/sr.
struct BulkTable {
    std::string mode;                 ///< "aggregate", "medium", "chapter", "independent" or "structure"
    double hostIndex = 1;             ///< index of refraction of what the particles are in
    std::vector<double> wavelengths;  ///< [nm], growing
    std::vector<double> angles;       ///< nodes [degrees], 0 (straight on) first, 180 last, growing
    std::vector<double> sigmaS, sigmaA, g;                     ///< one for each wavelength; sigma in 1/mm
    std::vector<double> errorSigmaS, errorSigmaA, errorPhase;  ///< standard errors; empty: not known
    std::vector<std::vector<double>> phase;    ///< p for each wavelength, linear in the cosine between nodes
    std::vector<std::vector<double>> mueller;  ///< optional; for each wavelength S12/S11, S22/S11, S33/S11,
                                               ///< S34/S11, S44/S11 at each angle in turn
    std::string made;  ///< JSON text of the entry "made": the program, seed, input; "" if there is none
};

/// Reads a file, zipped or not, of at most 64 MB.
/// @param loc  what names the file, where something does
/// Errors: FileError at `loc` if it cannot be read; SceneError with line and column in the file for what is
/// no such table: no JSON, unknown, missing or repeated keys, lists of other lengths, numbers out of their
/// range or order, a p whose NormOfPhase() is not 1 to within 1e-6, an oriented ensemble.
BulkTable ReadBulkTable(const std::string& path, const FileLoc& loc = {});

/// The text of a file, with 9 significant digits; reading and writing it again gives the same bytes. All
/// numbers must be finite, and lists as long as BulkTable says.
std::string WriteBulkTable(const BulkTable& table);

/// 2 pi times the integral of p over the cosine, linear in the cosine between nodes, as it is rendered.
double NormOfPhase(std::span<const double> anglesDeg, std::span<const double> phase);

}  // namespace lacquer
