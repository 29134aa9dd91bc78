// Gaussians to test with, and integrals of them over fine grids.
#pragma once

#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::test {

/// Precisions p and q along axes turned by `angle`, mean (x, y).
inline Gaussian2 Turned(float x, float y, float p, float q, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return {{x, y}, {p * c * c + q * s * s, (p - q) * c * s, p * s * s + q * c * c}};
}

/// As fitted lobes are: round, narrow, oblique, of the smallest alpha (0.005: precision 8e4), and grazing.
inline const Gaussian2 kGaussians[] = {Turned(0, 0, 1, 1, 0), Turned(0.3f, -0.5f, 20, 50, 0.4f),
                                       Turned(-1, 2, 900, 3, 1.1f), Turned(0.6f, 0.1f, 8e4f, 2e4f, 2),
                                       Turned(3, -4, 0.05f, 2e3f, 2.2f)};

/// Sum of f over a grid of +-7 standard deviations of g. Its error is below 1e-6 of the sum for functions as
/// smooth as g.
template <class Function>
double Integrate(const Gaussian2& g, const Function& f) {
    constexpr int kCells = 200;
    constexpr double kReach = 7, kStep = 2 * kReach / kCells;
    const CholeskyFactor l = g.Factorize();
    double sum = 0;
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j)
            sum += f(g.mean + l.FromStandard(
                                  {float(-kReach + (i + 0.5) * kStep), float(-kReach + (j + 0.5) * kStep)}));
    return sum * kStep * kStep / double(l.Volume());
}

}  // namespace lacquer::test
