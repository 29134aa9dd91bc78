// Summaries as a function of the parameters, learnt from simulations: their mean over seeds, and how they
// scatter.
#pragma once

#include "estimate/covariance/projection.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/emulator/monomials.h"
#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// A regression of summaries on parameters and the likelihood that its residuals make: a synthetic likelihood
/// [Wood 2010; Price et al. 2018] without new simulations at each point. Residuals are one seed's scatter and
/// the misfit of the polynomials together, which both belong into it; the error of the regression itself
/// widens it where there are few simulations.
class SummaryEmulator {
  public:
    struct Options {
        int degree = 2;  ///< of the polynomials, 1 to 3
        /// Logarithms of the residuals' variances are linear in the parameters rather than constant. For few
        /// summaries, and many simulations for each: of correlated summaries the slopes err together, and the
        /// sum of all their errors pulls the posterior. 40 summaries from 500 simulations make intervals of
        /// 90 % that hold 73 % (docs/estimation-inference.md).
        bool hasVaryingVariance = false;
        CovarianceError covarianceError = CovarianceError::Student;
    };
    /// @param parameters  a column for each simulation; more of them than the polynomials have terms, and
    /// then ten
    /// @param summaries   a row for each simulation
    /// Errors: CheckError for too few simulations.
    SummaryEmulator(const Matrix& parameters, const Matrix& summaries, const Options& options);

    /// What observed summaries become once, for many calls of LogLikelihood().
    Vector Project(const Vector& summaries) const { return projection_.Apply(summaries); }
    /// Logarithm of the likelihood of projected summaries, up to a constant.
    /// @param gradient   d/dy if not null
    /// @param inflation  of the covariance, for what the model does not explain
    double LogLikelihood(const Vector& y, const Vector& projected, Vector* gradient = nullptr,
                         double inflation = 1) const;
    /// Squared residual in units of the covariance: about NumSummaries() where the model is right.
    double Misfit(const Vector& y, const Vector& projected) const;
    /// Observed minus emulated, in standard deviations, for each projected summary.
    Vector StandardizedResidual(const Vector& y, const Vector& projected) const;
    Eigen::Index NumSummaries() const { return projection_.Size(); }
    /// Squared length of the way from the centre of the simulations, in their covariance.
    double Distance(const Vector& y) const { return Standardized(y).squaredNorm(); }
    static Eigen::Index NumTerms(Eigen::Index numParameters, int degree) {
        return Monomials(numParameters, degree).Size();
    }

  private:
    Vector Standardized(const Vector& y) const { return whitening_ * (y - center_); }
    void FitVariances(const Matrix& design, const Vector& leverages, const Matrix& residuals);
    /// Means by weighted least squares, with the variances as they are.
    void FitMeans(const Matrix& basis, const Matrix& design, const Matrix& values);

    Options options_;
    Vector center_;
    Matrix whitening_;  ///< from y to coordinates in which the simulations have unit covariance
    SummaryProjection projection_;
    Monomials monomials_;
    Matrix coefficients_;  ///< a row for each term, a column for each summary
    Matrix logVariances_;  ///< a row for 1 and each coordinate, a column for each summary
    Matrix inverseGram_;   ///< of the terms: the regression's own variance
    ResidualLikelihood likelihood_;
};

}  // namespace lacquer::estimate
