// How large the computation of a table is, before it is begun.
#pragma once

#include "bulk/table/ensemble_computation.h"

namespace lacquer::bulk {

/// In the host [1/um]. @param wavelength  in vacuum [nm]
double WavenumberOf(const BulkSettings& settings, double wavelength);
/// Of all species and listed particles [um].
double LargestRadius(const BulkSettings& settings);
/// The coefficient [1/mm] of particles whose k^2 C is 1 each. @param wavelength  in vacuum [nm]
double CoefficientOfUnit(const BulkSettings& settings, const Ensemble& ensemble, double wavelength);
/// Radius of a ball about the origin that holds the particles, whatever the realisation [um].
double ReachOf(const Ensemble& ensemble);
/// Coefficients of the waves of a mean realisation, for one polarisation, at the shortest wavelength.
double NumUnknowns(const BulkSettings& settings);

/// Degrees at one wavelength, and numbers of angles for all.
struct BulkDegrees {
    int spheres = 1;   ///< of expansions about the centres of particles
    int farField = 1;  ///< of the one about the origin
};
BulkDegrees DegreesAt(const BulkSettings& settings, const Ensemble& ensemble, double wavelength);
int NumAnglesOf(const BulkSettings& settings, const Ensemble& ensemble);

/// Bytes that a computation takes, about: what is kept for all wavelengths, and what `numThreads` solutions
/// at once do.
double MemoryOf(const BulkSettings& settings, const Ensemble& ensemble, int numThreads);

}  // namespace lacquer::bulk
