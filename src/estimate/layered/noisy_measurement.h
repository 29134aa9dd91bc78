// A simulator of whole measurements, noise included: what tests of calibration draw from.
#pragma once

#include <functional>

#include "estimate/calibration/simulation_based.h"
#include "estimate/layered/lobe_posterior.h"

namespace lacquer::estimate {

/// Observations are logarithms with noise, then the standard errors of the simulation that they are made
/// from, which the likelihood is told.
class NoisyMeasurement final : public Simulator {
  public:
    /// Values and their standard errors (as of a simulator of reflectances), by more samples than usual, so
    /// that a truth has an error of its own far below the noise.
    using Truth = std::function<Vector(const Vector& x, uint64_t seed)>;
    /// @param space  WithNoise(); outlives the object
    NoisyMeasurement(const ParameterSpace& space, std::vector<std::string> names, Truth truth, double floor)
        : space_(space), names_(std::move(names)), truth_(std::move(truth)), floor_(floor) {}
    const ParameterSpace& Parameters() const override { return space_; }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override;
    /// What Simulate() gave, for a likelihood.
    ObservedLobes Observed(const Vector& summaries) const;

  private:
    const ParameterSpace& space_;
    std::vector<std::string> names_;
    Truth truth_;
    double floor_;
};

}  // namespace lacquer::estimate
