// The points of a regression, and what of it depends on them alone.
#pragma once

#include "estimate/emulator/monomials.h"
#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// Least squares by polynomials of the parameters, in coordinates in which the simulations have unit
/// covariance, with a ridge of the terms that are not linear.
class PolynomialBasis {
  public:
    PolynomialBasis() = default;
    /// @param parameters  a column for each simulation; at least ten more than the polynomials have terms
    /// Errors: CheckError for too few simulations.
    PolynomialBasis(const Matrix& parameters, int degree);
    /// Gives the coefficients of squares, products and cubes a common prior deviation, by which sets of
    /// values (a column for each) are best predicted with one simulation left out [Allen 1974]: where the
    /// means are nearly linear, many such terms would only add their errors.
    void ChooseRidge(const Matrix& values);
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
    /// The same for one set of values, with weights of the simulations.
    Vector FitWeighted(const Vector& values, const Vector& weights) const;
    const Matrix& TermsOfRuns() const { return terms_; }
    /// Of each simulation.
    Vector Leverages() const { return (terms_ * inverseGram_).cwiseProduct(terms_).rowwise().sum(); }
    /// Terms that are free, less than all of them with a ridge.
    double NumFree() const { return Leverages().sum(); }
    Matrix StandardizedRuns(const Matrix& parameters) const {
        return (whitening_ * (parameters.colwise() - center_)).transpose();
    }
    Eigen::Index NumTerms() const { return monomials_.Size(); }

  private:
    Vector center_;
    Matrix whitening_;
    Monomials monomials_;
    Matrix terms_;      ///< a row for each simulation
    double ridge_ = 0;  ///< of the terms that are not linear, over the number of simulations
    Matrix inverseGram_;
    /// With the ridge, of a Gram matrix of the terms.
    Matrix Inverse(Matrix gram, double ridge) const;
};

}  // namespace lacquer::estimate
