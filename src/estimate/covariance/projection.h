// Fewer numbers in place of many summaries.
#pragma once

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// Summaries in units of their spread, and if there are many for the number of simulations, their leading
/// principal components.
class SummaryProjection {
  public:
    SummaryProjection() = default;
    /// @param summaries  a row for each simulation. More than a third as many columns as rows are projected,
    /// on at most 60 components and at most a quarter of the rows, with singular values above 1e-3 of the
    /// first
    explicit SummaryProjection(const Matrix& summaries);
    /// Every summary in a unit of its own, about zero.
    static SummaryProjection WithUnits(const Vector& units);
    Eigen::Index Size() const { return isProjected_ ? components_.cols() : means_.size(); }
    bool IsProjected() const { return isProjected_; }
    Vector Apply(const Vector& summaries) const;
    /// From derivatives by the result of Apply() those by the summaries.
    Vector ApplyTransposed(const Vector& byResult) const {
        return (isProjected_ ? Vector(components_ * byResult) : byResult).cwiseQuotient(sds_);
    }
    /// Of each row.
    Matrix ApplyToRows(const Matrix& summaries) const;

  private:
    Vector means_, sds_;
    Matrix components_;  ///< a column for each
    bool isProjected_ = false;
};

}  // namespace lacquer::estimate
