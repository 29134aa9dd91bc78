// From particles to a table that media and slabs render.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bulk/table/ensemble_computation.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::bulk {

/// What a table has at one wavelength; coefficients [1/mm] and g with standard errors.
struct BulkRow {
    ScatteringAverage::Value sigmaS, sigmaA, g;
    std::vector<double> phase;
    double errorPhase = 0;
    std::vector<double> mueller;  ///< as in BulkTable; empty if it is not known
};

/// Of ensembles without an axis: light along z is any light.
class BulkComputation final : public EnsembleComputation {
  public:
    explicit BulkComputation(BulkSettings settings);

    int NumAveraged(size_t wavelength) const override { return sums_[wavelength].NumRealizations(); }
    ConvergencePoint MeansAt(size_t wavelength) const override;
    ScatteringAverage AverageAt(size_t wavelength) const { return AverageAt(wavelength, Settings().mode); }
    /// The same realisations, averaged otherwise.
    ScatteringAverage AverageAt(size_t wavelength, AverageMode mode) const {
        return sums_[wavelength].Average(mode);
    }
    /// What the same particles scatter by a method without clusters, whatever that of the settings. Without
    /// errors and Mueller matrices; the extinction is that of particles far apart.
    ScatteringAverage WithoutClusters(size_t wavelength, BulkMethod method) const;
    /// At each wavelength, with at least as many realisations as the mode needs. Errors: SceneError without a
    /// place if they leave no scattering, or let too little light through where multiple scattering is
    /// removed.
    std::vector<BulkRow> Rows() const;
    /// @param rows  Rows()
    BulkTable TableOf(std::vector<BulkRow> rows) const;
    BulkTable Table() const { return TableOf(Rows()); }

  private:
    std::unique_ptr<Solution> Solve(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                    size_t wavelength, Observer* observer) const override;
    void Add(const Solution& solution, size_t wavelength) override;
    std::vector<double> SumsState(size_t wavelength) const override { return sums_[wavelength].State(); }
    size_t SumsSize(size_t wavelength) const override { return sums_[wavelength].StateSize(); }
    void SetSums(size_t wavelength, std::span<const double> state) override {
        sums_[wavelength].SetState(state);
    }
    void RequireScattering(const ScatteringAverage& average, size_t wavelength) const;
    BulkRow RowAt(size_t wavelength) const;
    std::vector<double> AnglesDeg() const;
    /// From a ball's numbers to those of the medium.
    void RemoveMultipleScattering(size_t wavelength, BulkRow* row) const;

    int numAngles_;
    std::vector<AzimuthalHarmonics> harmonics_;  ///< of each wavelength
    std::vector<ScatteringSums> sums_;
};

}  // namespace lacquer::bulk
