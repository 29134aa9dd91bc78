#include "bulk/table/bulk_problem.h"

#include <algorithm>
#include <numbers>

#include "bulk/cluster/coupling.h"

namespace lacquer::bulk {
namespace {

int DegreeOfSpheres(const BulkSettings& settings, double wavelength) {
    return MieDegree(WavenumberOf(settings, wavelength) * LargestRadius(settings)) +
           settings.realization.extraDegree;
}

}  // namespace

double WavenumberOf(const BulkSettings& settings, double wavelength) {
    constexpr double kNanometresInMicrometre = 1000;
    return 2 * std::numbers::pi * settings.hostIndex * kNanometresInMicrometre / wavelength;
}

double LargestRadius(const BulkSettings& settings) {
    double largest = 0;
    for (const Species& species : settings.ensemble.species)
        largest = std::max(largest, species.radius.Largest());
    for (const Particle& particle : settings.ensemble.particles) largest = std::max(largest, particle.radius);
    return largest;
}

double CoefficientOfUnit(const BulkSettings& settings, const Ensemble& ensemble, double wavelength) {
    constexpr double kMicrometresInMillimetre = 1000;
    const double k = WavenumberOf(settings, wavelength);
    return ensemble.NumberDensity() / (k * k) * kMicrometresInMillimetre;
}

double ReachOf(const Ensemble& ensemble) {
    const EnsembleSettings& settings = ensemble.Settings();
    double largest = 0, reach = ensemble.BallRadius();
    for (const Species& species : settings.species) largest = std::max(largest, species.radius.Largest());
    if (settings.arrangement == Arrangement::Gaussian) reach = 3 * settings.deviations.norm();
    for (const Particle& particle : settings.particles)
        reach = std::max(reach, particle.center.norm() + particle.radius);
    return reach + largest;
}

double NumUnknowns(const BulkSettings& settings) {
    const int degree = DegreeOfSpheres(settings, settings.wavelengths.front());
    return 2. * settings.ensemble.count * degree * (degree + 2.);  // beyond integers where nothing is solved
}

BulkDegrees DegreesAt(const BulkSettings& settings, const Ensemble& ensemble, double wavelength) {
    // Without clusters: of a particle, or of those whose places depend on each other, about ten radii.
    constexpr double kCorrelated = 10;
    const double reach =
        settings.method == BulkMethod::Clusters ? ReachOf(ensemble) : kCorrelated * LargestRadius(settings);
    const double kReach = WavenumberOf(settings, wavelength) * reach;
    return {DegreeOfSpheres(settings, wavelength),
            FarFieldDegree(kReach, MieDegree(kReach) + settings.realization.extraDegree)};
}

int NumAnglesOf(const BulkSettings& settings, const Ensemble& ensemble) {
    const int degree = DegreesAt(settings, ensemble, settings.wavelengths.front()).farField;
    // Even numbers of steps with whole degrees among the nodes, enough for intensities of this degree.
    return 180 * std::max(1, (2 * degree + 179) / 180) + 1;
}

double MemoryOf(const BulkSettings& settings, const Ensemble& ensemble, int numThreads) {
    constexpr double kComplex = 16, kSumsOfAngle = 24 * 15 * 8;
    const double numAngles = NumAnglesOf(settings, ensemble), count = settings.ensemble.count;
    double kept = 0, ofThread = 0;
    for (const double wavelength : settings.wavelengths) {
        const BulkDegrees degrees = DegreesAt(settings, ensemble, wavelength);
        kept += numAngles * kSumsOfAngle;
        if (settings.method != BulkMethod::Clusters) continue;
        const double far = degrees.farField, near = degrees.spheres;
        kept += numAngles * 4 * far * (far + 2) * kComplex;
        // Vectors of the solver, both columns; pairs; tables of pairs; rotations to the origin.
        const double vectors = 2 * (settings.realization.solver.restart + 6) * 2 * count * near * (near + 2),
                     numPairs = count * (count - 1) / 2,
                     tables = std::min(8 * numPairs * double(Coupling::TableSize(degrees.spheres)),
                                       double(settings.realization.memory) / numThreads);
        ofThread = std::max(ofThread, kComplex * vectors + 8 * numPairs + tables + 8 * far * far * near);
    }
    return kept + numThreads * ofThread;
}

}  // namespace lacquer::bulk
