#include "estimate/emulator/polynomial_basis.h"

#include <Eigen/Cholesky>

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
    // A ridge far below what data tell.
    Matrix gram = terms_.transpose() * terms_;
    gram.diagonal().array() += 1e-10 * gram.trace() / double(gram.rows());
    inverseGram_ = gram.ldlt().solve(Matrix::Identity(gram.rows(), gram.cols()));
}

}  // namespace lacquer::estimate
