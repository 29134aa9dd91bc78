// From particles to a table that media and slabs render.
#pragma once

#include <span>
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

/// What is known of cross sections after some realisations, k^2 C for each particle.
struct ConvergencePoint {
    int numRealizations = 0;
    ScatteringAverage::Value extinction, scattering, g;
};

/// Particles as the solver has them. @param wavelength  in vacuum [nm]
std::vector<Sphere> SpheresOf(const BulkSettings& settings, const std::vector<Particle>& particles,
                              double wavelength);
/// As files have it: "aggregate", "medium" or "chapter".
const char* ModeName(AverageMode mode);

/// Averages realisations, some at a time. What it finds depends on the settings and on the number of
/// realisations alone, not on threads nor on how many are added at once.
class BulkComputation {
  public:
    explicit BulkComputation(BulkSettings settings);
    /// Solves the next `count` realisations at all wavelengths. Stops earlier if the observer says so: what
    /// is being solved is finished, and whole realisations among it are added. Not for the methods without
    /// clusters. Errors: SceneError if there is no room for the particles.
    /// @param observer  or null; advances by a unit for each realisation and wavelength
    void AddRealizations(int count, Observer* observer);

    /// How many realisations are solved at once.
    int BatchSize() const;
    int NumRealizations() const { return numRealizations_; }
    int NumRefused() const {
        return numRefused_;
    }  ///< solutions that did not converge; they are in no average
    double WorstEnergyError() const { return worstEnergyError_; }
    /// Realisations in the average, those that were not refused; and how many the mode needs at least.
    int NumAveraged(size_t wavelength) const { return sums_[wavelength].NumRealizations(); }
    int NumNeeded() const { return settings_.mode == AverageMode::Aggregate ? 1 : 2; }
    ScatteringAverage AverageAt(size_t wavelength) const { return AverageAt(wavelength, settings_.mode); }
    /// The same realisations, averaged otherwise.
    ScatteringAverage AverageAt(size_t wavelength, AverageMode mode) const {
        return sums_[wavelength].Average(mode);
    }
    /// What the same particles scatter by a method without clusters, whatever that of the settings. Without
    /// errors and Mueller matrices; the extinction is that of particles far apart.
    ScatteringAverage WithoutClusters(size_t wavelength, BulkMethod method) const;
    /// How the averages at a wavelength came about: after each realisation up to 64, and then after about
    /// every thirtieth part more. The same whatever the threads and steps.
    const std::vector<ConvergencePoint>& History(size_t wavelength) const { return history_[wavelength]; }
    double Wavenumber(size_t wavelength) const;  ///< in the host [1/um]
    /// All that was averaged and its history, for SetState() of a computation with the same settings, which
    /// then goes on to the same bits.
    std::vector<double> State() const;
    /// False, and nothing is changed, if these numbers are not of such a computation.
    bool SetState(std::span<const double> state);
    const Ensemble& GetEnsemble() const { return ensemble_; }
    const BulkSettings& Settings() const { return settings_; }
    /// With at least as many realisations as the mode needs. Errors: SceneError without a place if they leave
    /// no scattering.
    BulkTable Table() const;

  private:
    /// @return  realisations that were added, fewer than `size` if the observer stopped it
    int AddBatch(int size, Observer* observer);
    void Add(std::span<const SolvedRealization> ofAllWavelengths);
    void RequireScattering(const ScatteringAverage& average, size_t wavelength) const;

    BulkSettings settings_;
    Ensemble ensemble_;
    int numAngles_;
    std::vector<AzimuthalHarmonics> harmonics_;  ///< of each wavelength
    std::vector<ScatteringSums> sums_;
    std::vector<std::vector<ConvergencePoint>> history_;  ///< of each wavelength
    int numRealizations_ = 0, numRefused_ = 0;
    double worstEnergyError_ = 0;
};

}  // namespace lacquer::bulk
