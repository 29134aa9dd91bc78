#include "estimate/models/phases.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "estimate/models/streams.h"

namespace lacquer::estimate {
namespace {

/// cos and sin of 2 pi u, u in [0,1): polynomials on a quarter turn, which compilers make vectors of; errors
/// below 1e-13, far below what a random phase means.
struct Turn {
    double cosine, sine;
};
inline Turn TurnOf(double u) {
    const double quarter = std::floor(4 * u + 0.5);
    const double x = (u - 0.25 * quarter) * (2 * std::numbers::pi), x2 = x * x;
    double s = 1 / 6227020800., c = -1 / 87178291200.;
    s = s * x2 - 1 / 39916800.;
    s = s * x2 + 1 / 362880.;
    s = s * x2 - 1 / 5040.;
    s = s * x2 + 1 / 120.;
    s = s * x2 - 1 / 6.;
    s = x + x * x2 * s;
    c = c * x2 + 1 / 479001600.;
    c = c * x2 - 1 / 3628800.;
    c = c * x2 + 1 / 40320.;
    c = c * x2 - 1 / 720.;
    c = c * x2 + 1 / 24.;
    c = c * x2 - 0.5;
    c = 1 + x2 * c;
    const bool isOdd = quarter == 1 || quarter == 3;
    const double cosine = isOdd ? s : c, sine = isOdd ? c : s;
    return {quarter == 1 || quarter == 2 ? -cosine : cosine, quarter == 2 || quarter == 3 ? -sine : sine};
}

}  // namespace

void FillPhases(uint64_t stream, ComplexGrid* half) {
    const int n = half->rows, count = half->columns;
    const auto columns = size_t(count);
    std::vector<double> phases(columns), opposite(columns);
    for (int row = 0; row < n; ++row) {
        const int ky = SignedFrequency(row, n);
        // In a loop of its own: compilers make no vectors of what turns 64 bits into a double.
        for (int kx = 0; kx < count; ++kx) {
            phases[size_t(kx)] = UnitAt(stream, ky, kx);
            opposite[size_t(kx)] = UnitAt(stream, -ky, -kx);
        }
        double* re = &half->re[half->Index(row, 0)];
        double* im = &half->im[half->Index(row, 0)];
        const double* u = phases.data();
        const double* v = opposite.data();
        for (int kx = 0; kx < count; ++kx) {
            const Turn a = TurnOf(u[kx]), b = TurnOf(v[kx]);
            re[kx] = 0.5 * (a.cosine + b.cosine);
            im[kx] = 0.5 * (a.sine - b.sine);
        }
    }
    half->re[0] = half->im[0] = 0;
}

}  // namespace lacquer::estimate
