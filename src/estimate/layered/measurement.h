// Reflectances that a goniometer has measured, and the directions that they are of.
#pragma once

#include <string>
#include <vector>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// Where light comes from (i) and where it is seen from (o), from the normal and around it [degrees].
struct DirectionAngles {
    double thetaI = 0, phiI = 0, thetaO = 0, phiO = 0;
    /// "30, 0 to 45, 180"
    std::string ToString() const;
};

/// Values of a BRDF [1/sr], without the cosine.
struct Measurement {
    std::vector<DirectionAngles> directions;  ///< one for each row
    /// One for each row [nm], and a row has one value; empty: rows are r, g, b in linear sRGB.
    std::vector<double> wavelengths;
    Matrix values;      ///< a row for each direction, a column for each channel; positive
    Matrix deviations;  ///< standard deviations of the values, 0 where the file has none

    Eigen::Index NumRows() const { return Eigen::Index(directions.size()); }
    bool IsColor() const { return wavelengths.empty(); }
    /// All values row after row, as simulators have them.
    Vector Flat() const;
    /// Deviations over values, in the order of Flat().
    Vector RelativeDeviations() const;
};

/// Reads columns theta_i, phi_i, theta_o, phi_o with r, g, b or with wavelength, value, and perhaps sd, in
/// any order: names in the first line, commas between, '#' begins a comment. Errors: FileError; SceneError
/// with line and column for columns that are missing or not known (with the nearest name), rows of other
/// lengths, what is no number, directions at or below the horizon, values that are not positive or beyond
/// what can be measured, negative deviations, and a file without rows.
Measurement ReadMeasurement(const std::string& path);
/// What makes one suspect that values are in another unit: a sentence without its full stop, or nothing.
std::string Doubt(const Measurement& measurement);
/// The same as text, with all digits. @param withDeviations  a column sd, one for all channels of a row
std::string MeasurementCsv(const Measurement& measurement, bool withDeviations);

/// Directions alone, in the same format; other columns are not looked at. Errors: as above.
std::vector<DirectionAngles> ReadDirections(const std::string& path);

/// In the plane of incidence and across it, for light from 0 to 75 degrees: where a measurement could be made
/// next.
std::vector<DirectionAngles> CandidateDirections();
/// Lobes in the plane of incidence for light from 10, 35 and 60 degrees, denser where it is mirrored: what
/// synthetic measurements have.
std::vector<DirectionAngles> LobeDirections();

}  // namespace lacquer::estimate
