// Summaries as a function of the parameters, learnt from simulations: their mean over seeds, and how they
// scatter.
#pragma once

#include "estimate/covariance/regression_summaries.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/emulator/polynomial_basis.h"
#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// The likelihood of regression summaries, one for each parameter (or of the summaries themselves, where they
/// are no more than three for each): their means are polynomials of the parameters, and residuals of these
/// have the covariance of a synthetic likelihood [Wood 2010; Price et al. 2018] without new simulations at
/// each point. Residuals are one seed's scatter, the error of the regression
/// summaries and the misfit of the polynomials together, which all belong into it; the error of the
/// polynomials' coefficients widens it where there are few simulations.
class SummaryEmulator {
  public:
    struct Options {
        int degree = 2;  ///< of the polynomials, 1 to 3
        /// Logarithms of the residuals' variances are linear in the parameters rather than constant.
        bool hasVaryingVariance = true;
        CovarianceError covarianceError = CovarianceError::Student;
    };
    /// @param parameters  a column for each simulation; at least ten more than the polynomials have terms
    /// @param summaries   a row for each simulation
    /// Errors: CheckError for too few simulations.
    SummaryEmulator(const Matrix& parameters, const Matrix& summaries, const Options& options);

    /// What observed summaries become once, for many calls of LogLikelihood().
    Vector Project(const Vector& summaries) const { return regression_.Apply(summaries); }
    /// Logarithm of the likelihood of projected summaries, up to a constant. Beyond nearly all simulations,
    /// where polynomials say nothing and their error makes the likelihood flat, it falls off as the
    /// simulations do.
    /// @param gradient   d/dy if not null
    /// @param inflation  of the covariance, for what the model does not explain
    double LogLikelihood(const Vector& y, const Vector& projected, Vector* gradient = nullptr,
                         double inflation = 1) const;
    /// Variance that the few simulations add at y, over what it would be with many: by errors of the
    /// polynomials, which are part of the likelihood, and of the regression summaries, for others would be as
    /// good.
    double Leverage(const Vector& y) const {
        return basis_.Leverage(basis_.Terms(basis_.Standardized(y))) + regression_.Leverage();
    }

    static Eigen::Index NumTerms(Eigen::Index numParameters, int degree) {
        return Monomials(numParameters, degree).Size();
    }

  private:
    void FitVariances(const Matrix& runs, const Matrix& residuals);
    /// Means by weighted least squares, with the variances as they are.
    void FitMeans(const Matrix& runs, const Matrix& values);
    /// Deviations of all summaries at standardized points: a row for each.
    Matrix DeviationsAt(const Matrix& runs) const;

    Options options_;
    PolynomialBasis basis_;
    RegressionSummaries regression_;
    Matrix coefficients_;  ///< a row for each term, a column for each summary
    Matrix logVariances_;  ///< a row for 1 and each coordinate, a column for each summary
    ResidualLikelihood likelihood_;
    double squaredRadius_ = 0;  ///< of the simulations, standardized
};

}  // namespace lacquer::estimate
