// From particles to a table of an oriented ensemble, whose scattering depends on the direction of light.
#pragma once

#include <vector>

#include "bulk/averages/oriented_sums.h"
#include "bulk/table/bulk_computation.h"

namespace lacquer::bulk {

struct OrientedSettings {
    /// Directions of incident light from along the axis to across it, at even steps; scattered light is
    /// computed at twice as many angles.
    int numIncidences = 31;
    int numAzimuths = 61;  ///< at even steps from 0 to 180 degrees
};

/// As BulkComputation, for ensembles with an axis (z): each realisation is turned about it at random, and as
/// often upside down as not, and solved for light along each of the incidences. The table has the symmetry of
/// such an ensemble, also where one of finitely many realisations has not: scattering is reciprocal and even
/// in the azimuth, as an ensemble of particles and their mirror images has it.
class OrientedComputation {
  public:
    /// @param settings  of the method Clusters; the ensemble is oriented whatever it says itself
    OrientedComputation(BulkSettings settings, const OrientedSettings& oriented);
    /// As BulkComputation's, but if the observer stops it nothing of what was being solved is added.
    void AddRealizations(int count, Observer* observer);

    int NumRealizations() const { return numRealizations_; }
    int NumRefused() const { return numRefused_; }
    double WorstEnergyError() const { return worstEnergyError_; }
    int NumAveraged(size_t wavelength) const { return sums_[wavelength].NumRealizations(); }
    int NumNeeded() const { return settings_.mode == AverageMode::Aggregate ? 1 : 2; }
    OrientedAverage AverageAt(size_t wavelength) const { return sums_[wavelength].Average(settings_.mode); }
    const OrientedDirections& Directions(size_t wavelength) const { return directions_[wavelength]; }
    const Ensemble& GetEnsemble() const { return ensemble_; }
    const BulkSettings& Settings() const { return settings_; }
    /// sigma_t is sigma_s + sigma_a. Errors: SceneError if too few realisations leave no scattering in some
    /// direction (AverageMode::Medium: a difference of estimates).
    OrientedBulkTable Table() const;

  private:
    struct Row;
    Row RowOf(const OrientedAverage& average, size_t wavelength) const;

    BulkSettings settings_;
    OrientedSettings oriented_;
    Ensemble ensemble_;
    std::vector<OrientedDirections> directions_;  ///< of each wavelength, for its far fields
    std::vector<OrientedSums> sums_;
    int numRealizations_ = 0, numRefused_ = 0;
    double worstEnergyError_ = 0;
};

/// Bytes that intensities and waves of all incidences take, about, beside MemoryOf() of the solutions.
double MemoryOfOriented(const BulkSettings& settings, const OrientedSettings& oriented);

}  // namespace lacquer::bulk
