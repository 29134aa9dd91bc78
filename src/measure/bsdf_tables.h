// Materials as tables that other programs read.
#pragma once

#include <string>
#include <vector>

#include "measure/bsdf_subject.h"
#include "pbrt/core/progress.h"

namespace lacquer::measure {

/// Samples of a table's entry: evaluations at each set of wavelengths. Deterministic models take one.
struct TableOptions {
    int samples = 16;
    uint64_t seed = 0;
};

/// Lobes of what light from above is scattered into, as 4096 draws find them: a stack may have some that
/// light from above does not meet.
Lobes LobesFromAbove(const BsdfSubject& subject, uint64_t seed);

/// Reflection from above of an isotropic material by half and difference angles, 90 x 90 x 180 entries as the
/// MERL database has them [Matusik et al. 2003]: linear sRGB, f [1/sr], each at the middle of its cell; the
/// half angle grows with the square of its number. Entries whose directions lie below the surface are -1. The
/// detector has no size: specular peaks are left out.
struct MerlTable {
    static constexpr int kHalf = 90, kDifference = 90, kAzimuth = 180;
    std::vector<double> values;  ///< [channel][half][difference][azimuth]
    /// As the database's files: little-endian, scaled by channel.
    std::string Bytes() const;
};
/// @param observer  may be null
MerlTable TabulateMerl(const BsdfSubject& subject, const TableOptions& options, Observer* observer);

/// Reflection and transmission over the patches of Klems's full basis, 145 on each hemisphere, as programs
/// for daylight read them: means of f over the outgoing patch and over the incoming one, by the projected
/// solid angle of each; specular peaks are in the patches that they fall into.
struct KlemsTable {
    static constexpr int kPatches = 145;
    /// Luminous f [1/sr], [outgoing][incoming], for light from the front and from the back.
    std::vector<double> frontReflection, frontTransmission, backReflection, backTransmission;
    /// Projected solid angle of a patch [sr].
    static double SolidAngleOf(int patch);
    /// A document of the XML schema of WINDOW 6.
    std::string Xml(const std::string& name) const;
};
KlemsTable TabulateKlems(const BsdfSubject& subject, const TableOptions& options, Observer* observer);

}  // namespace lacquer::measure
