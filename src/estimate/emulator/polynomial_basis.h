// The points of a regression, and what of it depends on them alone.
#pragma once

#include "estimate/emulator/monomials.h"
#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// Least squares by polynomials of the parameters, in coordinates in which the simulations have unit
/// covariance.
class PolynomialBasis {
  public:
    PolynomialBasis() = default;
    /// @param parameters  a column for each simulation; at least ten more than the polynomials have terms
    /// Errors: CheckError for too few simulations.
    PolynomialBasis(const Matrix& parameters, int degree);
    Vector Standardized(const Vector& y) const { return whitening_ * (y - center_); }
    /// Values of the terms at a standardized point.
    Vector Terms(const Vector& t) const { return monomials_.At(t); }
    /// By y, of a sum with these weights of the terms.
    Vector Gradient(const Vector& t, const Vector& weights) const {
        return ToOriginal(monomials_.Gradient(t, weights));
    }
    /// A gradient by y of one by t.
    Vector ToOriginal(const Vector& byStandardized) const { return whitening_.transpose() * byStandardized; }
    /// Variance of a prediction in units of that of one simulation.
    double Leverage(const Vector& terms) const { return terms.dot(inverseGram_ * terms); }
    const Matrix& InverseGram() const { return inverseGram_; }
    /// Coefficients of the least squares: a row for each term, a column for each of those of `values`.
    Matrix Fit(const Matrix& values) const { return inverseGram_ * (terms_.transpose() * values); }
    const Matrix& TermsOfRuns() const { return terms_; }
    Matrix StandardizedRuns(const Matrix& parameters) const {
        return (whitening_ * (parameters.colwise() - center_)).transpose();
    }
    Eigen::Index NumTerms() const { return monomials_.Size(); }

  private:
    Vector center_;
    Matrix whitening_;
    Monomials monomials_;
    Matrix terms_;  ///< a row for each simulation
    Matrix inverseGram_;
};

}  // namespace lacquer::estimate
