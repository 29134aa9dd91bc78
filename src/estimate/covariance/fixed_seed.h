// The likelihood with fixed seeds: for the mode, for gradients, and as a cross-check of the emulated one.
#pragma once

#include <vector>

#include "estimate/covariance/projection.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/infer/target.h"
#include "estimate/simulator.h"

namespace lacquer::estimate {

/// How summaries scatter from seed to seed at one point of the parameters.
struct SummaryScatter {
    SummaryProjection projection;
    ShrunkCovariance covariance;  ///< of projected summaries
    double degrees = 0;
};
/// By `numRuns` runs at x (natural units) with seeds of their own, in parallel; the same for any number of
/// threads.
SummaryScatter MeasureScatter(const Simulator& simulator, const Vector& x, Eigen::Index numRuns,
                              uint64_t seed);

/// An error that was set by hand, in place of the scatter: the likelihood then has the mean of all squared
/// differences over error^2, as in [Guo et al. 2020]. Intervals by it are not calibrated.
SummaryScatter ScatterByHand(Eigen::Index numSummaries, double error);

/// Posterior with K fixed seeds: the mean of the summaries over them is a function of the parameters alone,
/// and at the truth differs from what was observed by a normal residual with (1 + 1/K) times the covariance
/// of the scatter.
class FixedSeedTarget final : public Target {
  public:
    struct Options {
        std::vector<uint64_t> seeds = {1, 2, 3, 4};
        CovarianceError covarianceError = CovarianceError::Hartlap;
        /// False leaves out 1/K, as [Guo et al. 2020] do: intervals are then too narrow.
        bool countsOwnScatter = true;
        double tau = 1;  ///< the covariance is multiplied by tau^2
    };
    /// @param simulator  outlives the object
    FixedSeedTarget(const Simulator& simulator, const Vector& observed, const SummaryScatter& scatter,
                    Options options);

    Eigen::Index Size() const override { return Eigen::Index(simulator_.Parameters().Size()); }
    const Simulator& Model() const { return simulator_; }
    bool HasGradient() const;
    /// Density of logits, with the Jacobian of the prior. A gradient needs HasGradient().
    double LogDensity(const Vector& y, Vector* gradient) const override;
    /// What the mode in natural units has least of: minus the logarithm of likelihood and prior, without the
    /// Jacobian.
    double Energy(const Vector& y, Vector* gradient) const;
    /// Half its squared length is the energy, up to a constant and for normal likelihoods: whitened
    /// residuals, then those of the prior.
    Vector Residuals(const Vector& y) const;
    /// Squared residual in units of the covariance: about the number of (projected) summaries if the model is
    /// right.
    double Misfit(const Vector& y) const;
    Eigen::Index NumSummaries() const { return projected_.size(); }

  private:
    /// Projected: model minus observed.
    Vector Residual(const Vector& y) const;
    double LogLikelihood(const Vector& y, Vector* gradient) const;

    const Simulator& simulator_;
    SummaryProjection projection_;
    ResidualLikelihood likelihood_;
    Vector projected_;
    Options options_;
    double inflation_;
};

}  // namespace lacquer::estimate
