#include "estimate/covariance/projection.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace lacquer::estimate {

SummaryProjection::SummaryProjection(const Matrix& summaries)
    : means_(summaries.colwise().mean()), isProjected_(3 * summaries.cols() > summaries.rows()) {
    const Matrix centered = summaries.rowwise() - means_.transpose();
    sds_ = ((centered.colwise().squaredNorm() / double(std::max<Eigen::Index>(1, summaries.rows() - 1)))
                .array()
                .sqrt() +
            1e-12)
               .matrix();
    if (!isProjected_) return;
    const Matrix z = centered * sds_.cwiseInverse().asDiagonal();
    // Eigenvalues are squares of singular values, in ascending order.
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(z.transpose() * z);
    const Vector& values = solver.eigenvalues();
    const Eigen::Index all = values.size(), most = std::min<Eigen::Index>({60, summaries.rows() / 4, all});
    Eigen::Index count = 0;
    while (count < most && values[all - 1 - count] > 1e-6 * values[all - 1]) ++count;
    components_ = solver.eigenvectors().rightCols(std::max<Eigen::Index>(1, count)).rowwise().reverse();
}

SummaryProjection SummaryProjection::WithUnits(const Vector& units) {
    SummaryProjection projection;
    projection.means_ = Vector::Zero(units.size());
    projection.sds_ = units;
    return projection;
}

Vector SummaryProjection::Apply(const Vector& summaries) const {
    const Vector z = (summaries - means_).cwiseQuotient(sds_);
    return isProjected_ ? Vector(components_.transpose() * z) : z;
}

Matrix SummaryProjection::ApplyToRows(const Matrix& summaries) const {
    const Matrix z = (summaries.rowwise() - means_.transpose()) * sds_.cwiseInverse().asDiagonal();
    return isProjected_ ? Matrix(z * components_) : z;
}

}  // namespace lacquer::estimate
