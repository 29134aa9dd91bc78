// Vectors and matrices of the estimation: sums over parameters and summaries are in double throughout.
#pragma once

#include <Eigen/Core>

namespace lacquer::estimate {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

}  // namespace lacquer::estimate
