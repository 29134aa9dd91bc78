#include "estimate/emulator/polynomial_basis.h"

#include <Eigen/Cholesky>
#include <limits>

#include "estimate/infer/population.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {

PolynomialBasis::PolynomialBasis(const Matrix& parameters, int degree)
    : center_(parameters.rowwise().mean()),
      whitening_(CholeskyFactor(CovarianceOfColumns(parameters))
                     .triangularView<Eigen::Lower>()
                     .solve(Matrix::Identity(parameters.rows(), parameters.rows()))),
      monomials_(parameters.rows(), degree),
      terms_(parameters.cols(), monomials_.Size()) {
    LACQUER_CHECK(parameters.cols() >= monomials_.Size() + 10);
    for (Eigen::Index i = 0; i < parameters.cols(); ++i)
        terms_.row(i) = monomials_.At(Standardized(parameters.col(i)));
    inverseGram_ = Inverse(terms_.transpose() * terms_, 0);
}

Matrix PolynomialBasis::Inverse(Matrix gram, double ridge) const {
    const Eigen::Index numLinear = 1 + center_.size(), numOthers = gram.rows() - numLinear;
    // Far below what data tell, so that there always is an inverse; and the ridge, in units of the constant.
    gram.diagonal().array() += 1e-10 * gram.trace() / double(gram.rows());
    gram.diagonal().tail(numOthers).array() += ridge * gram(0, 0);
    return gram.ldlt().solve(Matrix::Identity(gram.rows(), gram.cols()));
}

void PolynomialBasis::ChooseRidge(const Matrix& values) {
    constexpr double kRidges[] = {0, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 100};
    const Matrix gram = terms_.transpose() * terms_;
    const Vector units =
        (values.rowwise() - values.colwise().mean()).colwise().squaredNorm().array() + 1e-300;
    double best = std::numeric_limits<double>::infinity();
    for (const double ridge : kRidges) {
        const Matrix inverse = Inverse(gram, ridge);
        const Vector leverages = (terms_ * inverse).cwiseProduct(terms_).rowwise().sum();
        const Matrix residuals = values - terms_ * (inverse * (terms_.transpose() * values));
        const Matrix leftOut = (1 - leverages.array()).max(1e-3).inverse().matrix().asDiagonal() * residuals;
        // The sum of logarithms does not depend on units; what is fitted exactly has no say.
        const double error =
            (leftOut.colwise().squaredNorm().transpose().cwiseQuotient(units).array() + 1e-12).log().sum();
        if (!(error < best)) continue;
        best = error;
        ridge_ = ridge;
        inverseGram_ = inverse;
    }
}

Vector PolynomialBasis::FitWeighted(const Vector& values, const Vector& weights) const {
    const Matrix weighted = weights.asDiagonal() * terms_;
    return Inverse(terms_.transpose() * weighted, ridge_) * (weighted.transpose() * values);
}

}  // namespace lacquer::estimate
