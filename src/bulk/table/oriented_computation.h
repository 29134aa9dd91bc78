// From particles to a table of an oriented ensemble, whose scattering depends on the direction of light.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bulk/averages/oriented_sums.h"
#include "bulk/table/ensemble_computation.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::bulk {

struct OrientedSettings {
    /// Directions of incident light from along the axis to across it, at even steps; scattered light is
    /// computed at twice as many angles.
    int numIncidences = 31;
    int numAzimuths = 61;  ///< at even steps from 0 to 180 degrees
};

/// Cross sections for light along one incidence, or their mean over all directions of incident light, k^2 C
/// for each particle, with standard errors; those are 0 for fewer than OrientedSums::kNumGroups + 2
/// realisations.
struct OrientedMeans {
    ScatteringAverage::Value extinction, scattering, absorption;
    /// Scattering and absorption together: sigma_t of tables. In the modes Medium and Chapter scattering is a
    /// part of what the extinction loses.
    ScatteringAverage::Value sum;
    ScatteringAverage::Value albedo;  ///< scattering over scattering and absorption
    ScatteringAverage::Value g;
};

/// Of ensembles with an axis (z): each realisation is turned about it at random, and as often upside down as
/// not, and solved for light along each of the incidences. The table has the symmetry of such an ensemble,
/// also where one of finitely many realisations has not: scattering is reciprocal and even in the azimuth, as
/// an ensemble of particles and their mirror images has it.
class OrientedComputation final : public EnsembleComputation {
  public:
    /// @param settings  of the method Clusters; the ensemble is oriented whatever it says itself
    OrientedComputation(BulkSettings settings, const OrientedSettings& oriented);

    /// Realisations that are solved at once.
    static int BatchSizeFor(size_t numWavelengths);
    /// A unit for each wavelength and incidence; an observer may stop between them, and what was solved of
    /// that realisation is lost.
    int64_t UnitsPerRealization() const override;
    int NumAveraged(size_t wavelength) const override { return sums_[wavelength].NumRealizations(); }
    /// Means over all directions of incident light.
    ConvergencePoint MeansAt(size_t wavelength) const override;
    /// At each incidence, before they are made reciprocal. Cost: for each incidence that of MeansAt(), which
    /// takes all incidences: seconds for 91 of them.
    std::vector<OrientedMeans> MeansOfIncidences(size_t wavelength) const;
    OrientedMeans MeansOverIncidences(size_t wavelength) const;
    OrientedAverage AverageAt(size_t wavelength) const { return sums_[wavelength].Average(Settings().mode); }
    const OrientedDirections& Directions(size_t wavelength) const { return directions_[wavelength]; }
    const OrientedSettings& Oriented() const { return oriented_; }
    /// sigma_t is sigma_s + sigma_a. Errors: SceneError if too few realisations leave no scattering in some
    /// direction (AverageMode::Medium: a difference of estimates).
    OrientedBulkTable Table() const;

  private:
    struct Row;
    std::unique_ptr<Solution> Solve(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                    size_t wavelength, Observer* observer) const override;
    void Add(const Solution& solution, size_t wavelength) override;
    std::vector<double> SumsState(size_t wavelength) const override { return sums_[wavelength].State(); }
    size_t SumsSize(size_t wavelength) const override { return sums_[wavelength].StateSize(); }
    void SetSums(size_t wavelength, std::span<const double> state) override {
        sums_[wavelength].SetState(state);
    }
    /// @param weights  of each incidence in the mean
    OrientedMeans WeightedMeans(size_t wavelength, const std::vector<double>& weights) const;
    Row RowOf(const OrientedAverage& average, size_t wavelength) const;

    OrientedSettings oriented_;
    std::vector<OrientedDirections> directions_;  ///< of each wavelength, for its far fields
    std::vector<OrientedSums> sums_;
};

/// Bytes that intensities and waves of all incidences take, about, beside MemoryOf() of the solutions.
double MemoryOfOriented(const BulkSettings& settings, const OrientedSettings& oriented);

}  // namespace lacquer::bulk
