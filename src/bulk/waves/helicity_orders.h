// Translations along z, order by order: where the two helicities do not mix.
#pragma once

#include <algorithm>

#include "bulk/conventions.h"

namespace lacquer::bulk {

/// Takes waves of each order and helicity, M + N or M - N, to waves of other degrees and the same order.
/// @param shift  (m, waves) -> waves: what M + N of order m become; rows from degree max(1, |m|). What M - N
///               of order m become is that of order -m.
template <class Shift>
Eigen::MatrixXcd ForHelicityOrders(const Eigen::MatrixXcd& in, int inDegree, int outDegree,
                                   const Shift& shift) {
    const int inSize = NumHarmonics(inDegree), outSize = NumHarmonics(outDegree);
    const int maxOrder = std::min(inDegree, outDegree);
    Eigen::MatrixXcd out = Eigen::MatrixXcd::Zero(2 * outSize, in.cols());
    for (int m = -maxOrder; m <= maxOrder; ++m) {
        const int lo = std::max(1, std::abs(m));
        for (const int helicity : {1, -1}) {
            Eigen::MatrixXcd waves(inDegree - lo + 1, in.cols());
            for (int n = lo; n <= inDegree; ++n)
                waves.row(n - lo) =
                    0.5 * (in.row(HarmonicIndex(n, m)) + helicity * in.row(inSize + HarmonicIndex(n, m)));
            const Eigen::MatrixXcd shifted = shift(helicity * m, waves);
            for (int nu = lo; nu <= outDegree; ++nu) {
                out.row(HarmonicIndex(nu, m)) += shifted.row(nu - lo);
                out.row(outSize + HarmonicIndex(nu, m)) += helicity * shifted.row(nu - lo);
            }
        }
    }
    return out;
}

}  // namespace lacquer::bulk
