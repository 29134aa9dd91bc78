// Files of "lacquer bulk": how a medium of particles scatters, by wavelength. docs/bulk.md describes them.
#pragma once

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "pbrt/core/error.h"

namespace lacquer {

/// What all such files say. Lengths in mm, p in 1/sr.
struct BulkHead {
    std::string mode;                 ///< "aggregate", "medium", "chapter", "independent" or "structure"
    double hostIndex = 1;             ///< index of refraction of what the particles are in
    std::vector<double> wavelengths;  ///< [nm], growing
    std::vector<double> angles;       ///< nodes [degrees], 0 first, 180 last, growing
    std::vector<double> g;            ///< mean cosine, one for each wavelength
    std::vector<double> errorSigmaS, errorSigmaA, errorPhase;  ///< standard errors; empty: not known
    std::string made;  ///< JSON text of the entry "made": the program, seed, input; "" if there is none
};

/// What a file says of an isotropic medium. Its angles are those of scattering, 0 straight on.
struct BulkTable : BulkHead {
    std::vector<double> sigmaS, sigmaA;        ///< one for each wavelength [1/mm]
    std::vector<std::vector<double>> phase;    ///< p for each wavelength, linear in the cosine between nodes
    std::vector<std::vector<double>> mueller;  ///< optional; for each wavelength S12/S11, S22/S11, S33/S11,
                                               ///< S34/S11, S44/S11 at each angle in turn
};

/// What a file says of a medium of an oriented ensemble: one that looks the same when it is turned about an
/// axis or mirrored, at the plane across the axis or at any along it. Its angles are those between the axis
/// and directions of flight, and lie symmetrically about 90 degrees: their first half are the incidences.
struct OrientedBulkTable : BulkHead {
    std::vector<std::vector<double>> sigmaS, sigmaA;  ///< for each wavelength one at each incidence [1/mm]
    int numAzimuths = 0;  ///< nodes of scattered minus incident azimuth, at equal steps from 0 to 180 degrees
    /// For each wavelength p at each incidence, angle (of the scattered light) and azimuth in turn; see
    /// scattering/oriented_table.h. Not in the JSON text, but in an image beside it, `phaseFile`.
    std::vector<std::vector<float>> phase;
    std::string phaseFile;
    std::vector<double> errorReciprocity;  ///< what making p reciprocal has changed; empty: not known

    size_t NumIncidences() const { return angles.size() / 2 + 1; }
};

/// Reads a file, zipped or not, of at most 64 MB.
/// @param loc  what names the file, where something does
/// Errors: FileError at `loc` if it cannot be read; SceneError with line and column in the file for what is
/// no such table: no JSON, unknown, missing or repeated keys, lists of other lengths, numbers out of their
/// range or order, a p whose NormOfPhase() is not 1 to within 1e-6. The p of an oriented ensemble is empty.
std::variant<BulkTable, OrientedBulkTable> ReadBulkFile(const std::string& path, const FileLoc& loc = {});
/// The same for isotropic media only; the file of an oriented ensemble is an error.
BulkTable ReadBulkTable(const std::string& path, const FileLoc& loc = {});

/// The text of a file, with 9 significant digits; reading and writing it again gives the same bytes. All
/// numbers must be finite, and lists as long as BulkTable says.
std::string WriteBulkTable(const BulkTable& table);
/// The JSON text, which names `phaseFile`.
std::string WriteBulkTable(const OrientedBulkTable& table);

/// 2 pi times the integral of p over the cosine, linear in the cosine between nodes, as it is rendered.
double NormOfPhase(std::span<const double> anglesDeg, std::span<const double> phase);

}  // namespace lacquer
