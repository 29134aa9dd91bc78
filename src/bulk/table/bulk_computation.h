// From particles to a table that media and slabs render.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bulk/table/ensemble_computation.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::bulk {

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
    /// With at least as many realisations as the mode needs. Errors: SceneError without a place if they leave
    /// no scattering.
    BulkTable Table() const;

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

    int numAngles_;
    std::vector<AzimuthalHarmonics> harmonics_;  ///< of each wavelength
    std::vector<ScatteringSums> sums_;
};

}  // namespace lacquer::bulk
