// Rules of numerical integration.
#pragma once

#include <vector>

namespace lacquer {

struct QuadratureNode {
    double x, weight;
};

/// The rule of Gauss and Legendre with n nodes on [-1, 1], falling in x: exact for polynomials of degree
/// 2n - 1. Weights to about 1e-14 / (1 - x^2). Cost O(n^2).
std::vector<QuadratureNode> GaussLegendre(int n);

}  // namespace lacquer
