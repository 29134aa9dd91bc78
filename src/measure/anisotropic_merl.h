// Anisotropic materials by half vector and difference, as a table.
#pragma once

#include <string>
#include <vector>

#include "measure/bsdf_tables.h"

namespace lacquer::measure {

/// Reflection from above by half and difference angles as in MerlTable, with the azimuth of the half vector
/// kept: linear sRGB, f [1/sr], each at the middle of its cell. The polar angle of the half vector grows with
/// the square of its number; a difference and the one across it are the same pair of directions exchanged,
/// so half a turn is enough. Entries whose directions lie below the surface are -1. The detector has no size:
/// specular peaks are left out.
struct AnisotropicMerlTable {
    struct Resolution {
        int half = 45, halfAzimuth = 36;              ///< of 90 and of 360 degrees
        int difference = 30, differenceAzimuth = 36;  ///< of 90 and of 180 degrees
    };
    Resolution resolution;
    std::vector<float> values;  ///< [channel][half][halfAzimuth][difference][differenceAzimuth]

    size_t NumCells() const {
        const Resolution& r = resolution;
        return size_t(r.half) * size_t(r.halfAzimuth) * size_t(r.difference) * size_t(r.differenceAzimuth);
    }
    /// A head of 32 bytes and the values; docs/guide.md has the layout.
    std::string Bytes() const;
};
/// @param observer  may be null
AnisotropicMerlTable TabulateAnisotropicMerl(const BsdfSubject& subject,
                                             AnisotropicMerlTable::Resolution resolution,
                                             const TableOptions& options, Observer* observer);

}  // namespace lacquer::measure
