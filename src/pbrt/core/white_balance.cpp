// White points: adaptation from one to another, and the CIE's formula for daylight.
#include <cmath>

#include "pbrt/core/color_space.h"
#include "pbrt/core/embedded.h"

namespace lacquer {

namespace {

/// Cone responses of the Bradford transform [Lam 1985]; rows as printed, so transposed for GLM.
const glm::dmat3 kBradford =
    glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296));

// Chromaticity x of daylight at a correlated colour temperature [K] [CIE 15:2004, eq. 3.3 and 3.4]; the
// formula ends at 25000 K.
double DaylightX(double t) {
    t = std::min(t, 25000.0);
    if (t <= 7000) return -4.6070e9 / (t * t * t) + 2.9678e6 / (t * t) + 0.09911e3 / t + 0.244063;
    return -2.0064e9 / (t * t * t) + 1.9018e6 / (t * t) + 0.24748e3 / t + 0.237040;
}

}  // namespace

glm::mat3 WhiteBalance(Point2 from, Point2 to) {
    const glm::dvec3 fromCone = kBradford * glm::dvec3(FromChromaticity(from, 1));
    const glm::dvec3 toCone = kBradford * glm::dvec3(FromChromaticity(to, 1));
    glm::dmat3 gains(0.0);
    for (int i = 0; i < 3; ++i) gains[i][i] = toCone[i] / fromCone[i];
    return glm::mat3(glm::inverse(kBradford) * gains * kBradford);
}

std::unique_ptr<DenselySampledSpectrum> DaylightSpectrum(float kelvin) {
    const float cct = kelvin * 1.4388f / 1.4380f;
    if (cct < 4000) return std::make_unique<DenselySampledSpectrum>(BlackbodySpectrum(cct));
    // Weights of the components by the chromaticity [CIE 15:2004, eq. 3.2 and 3.5].
    const double x = DaylightX(double(cct)), y = -3 * x * x + 2.870 * x - 0.275;
    const double m = 0.0241 + 0.2562 * x - 0.7341 * y;
    const double m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m, m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
    std::vector<float> lambda, values;
    for (const std::vector<double>& row : EmbeddedTable("spectra/illuminants/daylight-components.txt")) {
        lambda.push_back(float(row.at(0)));
        values.push_back(float(0.01 * (row.at(1) + m1 * row.at(2) + m2 * row.at(3))));
    }
    return std::make_unique<DenselySampledSpectrum>(
        PiecewiseLinearSpectrum::Extended(std::move(lambda), std::move(values)));
}

}  // namespace lacquer
