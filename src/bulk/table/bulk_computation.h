// From particles to a table that media and slabs render.
#pragma once

#include <vector>

#include "bulk/averages/realization.h"
#include "bulk/ensembles/ensemble.h"
#include "pbrt/core/progress.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::bulk {

/// Complex index of refraction over the wavelength, linear between nodes and constant beyond them.
class OpticalIndex {
  public:
    struct Node {
        double wavelength;  ///< in vacuum [nm]
        Complex index;      ///< Im >= 0 absorbs
    };
    explicit OpticalIndex(Complex index) : nodes_{{0, index}} {}
    /// @param nodes  at least one, wavelengths growing
    explicit OpticalIndex(std::vector<Node> nodes);
    Complex At(double wavelength) const;

  private:
    std::vector<Node> nodes_;
};

/// How scattering is computed.
enum class BulkMethod {
    Clusters,     ///< Maxwell's equations for realisations of the ensemble
    Independent,  ///< Lorenz-Mie theory, as if particles were far apart
    Structure     ///< the same times the structure factor of hard spheres by Percus and Yevick
};

struct BulkSettings {
    EnsembleSettings ensemble;          ///< lengths in micrometres
    std::vector<OpticalIndex> indices;  ///< of each species
    double hostIndex = 1;
    std::vector<double> wavelengths;  ///< in vacuum [nm], growing
    BulkMethod method = BulkMethod::Clusters;
    AverageMode mode = AverageMode::Medium;
    RealizationSettings realization;  ///< memory: for all that run at once
    uint64_t seed = 1;
};

/// Averages realisations, some at a time. What it finds depends on the settings and on the number of
/// realisations alone, not on threads nor on how many are added at once.
class BulkComputation {
  public:
    explicit BulkComputation(BulkSettings settings);
    /// Solves the next `count` realisations at all wavelengths. Stops earlier, after whole realisations, if
    /// the observer says so. Not for the methods without clusters.
    /// @param observer  or null; advances by a unit for each realisation and wavelength
    void AddRealizations(int count, Observer* observer);

    int NumRealizations() const { return numRealizations_; }
    int NumRefused() const {
        return numRefused_;
    }  ///< solutions that did not converge; they are in no average
    double WorstEnergyError() const { return worstEnergyError_; }
    ScatteringAverage AverageAt(size_t wavelength) const { return sums_[wavelength].Average(settings_.mode); }
    const Ensemble& GetEnsemble() const { return ensemble_; }
    const BulkSettings& Settings() const { return settings_; }
    /// With at least as many realisations as the mode needs.
    BulkTable Table() const;

  private:
    double Wavenumber(size_t wavelength) const;  ///< in the host [1/um]
    std::vector<Sphere> SpheresAt(const std::vector<Particle>& particles, size_t wavelength) const;
    ScatteringAverage WithoutClusters(size_t wavelength) const;

    BulkSettings settings_;
    Ensemble ensemble_;
    int numAngles_;
    std::vector<AzimuthalHarmonics> harmonics_;  ///< of each wavelength
    std::vector<ScatteringSums> sums_;
    int numRealizations_ = 0, numRefused_ = 0;
    double worstEnergyError_ = 0;
};

}  // namespace lacquer::bulk
