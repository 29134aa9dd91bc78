// Tables of oriented ensembles from closed forms, and files of them.
#pragma once

#include <functional>

#include "pbrt/core/vec.h"
#include "pbrt/phases/oriented_file.h"
#include "pbrt/scattering/oriented_table.h"
#include "support/bulk_tables.h"

namespace lacquer::test {

/// An ensemble about z: what it scatters from n into s (of flight) [1/mm/sr], and what it absorbs [1/mm].
struct OrientedMedium {
    std::function<double(Vec3 n, Vec3 s)> scattered;
    std::function<double(Vec3 n)> absorbed = [](Vec3) { return 0.; };
};

/// A direction at an angle to z [degrees] and an azimuth [radians].
inline Vec3 DirectionAt(double angleDeg, double phi) {
    const double theta = angleDeg * (M_PI / 180);
    return {float(std::sin(theta) * std::cos(phi)), float(std::sin(theta) * std::sin(phi)),
            float(std::cos(theta))};
}

/// The integral of what is scattered out of n, by a fine midpoint rule.
inline double ScatteredOut(const OrientedMedium& medium, Vec3 n) {
    constexpr int kCosines = 200, kAzimuths = 128;
    double sum = 0;
    for (int i = 0; i < kCosines; ++i)
        for (int k = 0; k < kAzimuths; ++k) {
            const double z = -1 + 2 * (i + 0.5) / kCosines, r = std::sqrt(1 - z * z);
            const double phi = 2 * M_PI * (k + 0.5) / kAzimuths;
            sum += medium.scattered(n, {float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)});
        }
    return sum * 4 * M_PI / (kCosines * kAzimuths);
}

/// @param media  one for each wavelength; @param numAngles  odd, at equal steps, as are the azimuths
inline OrientedBulkTable OrientedTable(std::vector<double> wavelengths,
                                       const std::vector<OrientedMedium>& media, int numAngles = 37) {
    OrientedBulkTable table;
    table.mode = "medium";
    table.wavelengths = std::move(wavelengths);
    table.angles = EqualAngles(numAngles);
    table.numAzimuths = numAngles;
    const OrientedGrid grid(table);
    for (const OrientedMedium& medium : media) {
        std::vector<double> scattered, sigmaS, sigmaA;
        for (size_t i = 0; i < grid.NumIncidences(); ++i) {
            const Vec3 n = DirectionAt(table.angles[i], 0);
            sigmaS.push_back(ScatteredOut(medium, n));
            sigmaA.push_back(medium.absorbed(n));
            for (const double angle : table.angles)
                for (int k = 0; k < numAngles; ++k)
                    scattered.push_back(medium.scattered(n, DirectionAt(angle, k * M_PI / (numAngles - 1))));
        }
        table.errorReciprocity.push_back(MakeReciprocal(grid, sigmaS, scattered));
        std::vector<float>& p = table.phase.emplace_back();
        for (size_t at = 0; at < scattered.size(); ++at)
            p.push_back(float(scattered[at] / sigmaS[at / (grid.NumAngles() * grid.NumAzimuths())]));
        table.sigmaS.push_back(sigmaS);
        table.sigmaA.push_back(sigmaA);
        table.g.push_back(0);
    }
    return table;
}

/// Path of the file of a table, with its image beside it.
inline std::string WriteFile(const std::string& name, const OrientedBulkTable& table) {
    const std::string path = WriteFile(name, std::string());
    WriteOrientedBulk(table, path);
    return path;
}

}  // namespace lacquer::test
