#include "pbrt/core/multiple_tests.h"

namespace lacquer {

double SidakCritical(double level, size_t numTests, double degreesOfFreedom) {
    // The normal quantile by bisection: of tests in a report, not of samples.
    double low = 0, high = 40;
    for (int i = 0; i < 100; ++i) {
        const double z = (low + high) / 2;
        (SidakP(TwoSidedNormalP(z), numTests) > level ? low : high) = z;
    }
    const double z = (low + high) / 2, z2 = z * z, v = degreesOfFreedom;
    return z * (1 + (z2 + 1) / (4 * v) + ((5 * z2 + 16) * z2 + 3) / (96 * v * v) +
                (((3 * z2 + 19) * z2 + 17) * z2 - 15) / (384 * v * v * v));
}

}  // namespace lacquer
