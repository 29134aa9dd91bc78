// Averages over realisations of an ensemble, at several wavelengths: what isotropic and oriented ones share.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bulk/averages/realization.h"
#include "bulk/ensembles/ensemble.h"
#include "pbrt/core/progress.h"

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
    /// Of the mode Medium, in balls: tables have the medium's numbers, not those of balls of it, in which
    /// light is scattered several times (ball_inversion.h).
    bool removesMultipleScattering = false;
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
class EnsembleComputation {
  public:
    virtual ~EnsembleComputation() = default;
    EnsembleComputation(EnsembleComputation&&) = default;
    EnsembleComputation& operator=(EnsembleComputation&&) = default;

    /// Solves the next `count` realisations at all wavelengths. Stops earlier if the observer says so: whole
    /// realisations among those that were solved are added. Not for the methods without clusters.
    /// Errors: SceneError if there is no room for the particles.
    /// @param observer  or null; advances by UnitsPerRealization() for each
    void AddRealizations(int count, Observer* observer);
    virtual int64_t UnitsPerRealization() const { return int64_t(settings_.wavelengths.size()); }

    /// How many realisations are solved at once.
    int BatchSize() const { return batchSize_; }
    int NumRealizations() const { return numRealizations_; }
    /// Solutions that did not converge; they are in no average.
    int NumRefused() const { return numRefused_; }
    double WorstEnergyError() const { return worstEnergyError_; }
    /// Realisations in the average, those that were not refused; and how many the mode needs at least.
    virtual int NumAveraged(size_t wavelength) const = 0;
    int NumNeeded() const { return settings_.mode == AverageMode::Aggregate ? 1 : 2; }
    /// Of all that was averaged, with NumNeeded() realisations at least.
    virtual ConvergencePoint MeansAt(size_t wavelength) const = 0;
    /// How MeansAt() came about: after each realisation up to 64, and then after about every thirtieth part
    /// more. The same whatever the threads and steps.
    const std::vector<ConvergencePoint>& History(size_t wavelength) const { return history_[wavelength]; }
    /// All that was averaged and its history, for SetState() of a computation with the same settings, which
    /// then goes on to the same bits.
    std::vector<double> State() const;
    /// False, and nothing is changed, if these numbers are not of such a computation.
    bool SetState(std::span<const double> state);
    double Wavenumber(size_t wavelength) const;  ///< in the host [1/um]
    const Ensemble& GetEnsemble() const { return ensemble_; }
    const BulkSettings& Settings() const { return settings_; }

  protected:
    /// @param tasksPerThread  solutions, of one realisation and wavelength each, in a batch
    EnsembleComputation(BulkSettings settings, int tasksPerThread);
    /// As of the constructor's batches.
    static int BatchSizeFor(size_t numWavelengths, int tasksPerThread);

    /// From several threads at once. Null if the observer stopped it.
    virtual std::unique_ptr<Solution> Solve(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                            size_t wavelength, Observer* observer) const = 0;
    /// Of a solution by Solve() that has converged.
    virtual void Add(const Solution& solution, size_t wavelength) = 0;
    /// Of the sums at a wavelength, as State() of all.
    virtual std::vector<double> SumsState(size_t wavelength) const = 0;
    virtual size_t SumsSize(size_t wavelength) const = 0;
    virtual void SetSums(size_t wavelength, std::span<const double> state) = 0;

  private:
    /// @return  realisations that were added, fewer than `size` if the observer stopped it
    int AddBatch(int size, Observer* observer);
    void AddRealization(std::span<const std::unique_ptr<Solution>> ofAllWavelengths);

    BulkSettings settings_;
    Ensemble ensemble_;
    int batchSize_;
    std::vector<std::vector<ConvergencePoint>> history_;  ///< of each wavelength
    int numRealizations_ = 0, numRefused_ = 0;
    double worstEnergyError_ = 0;
};

}  // namespace lacquer::bulk
