#include "pbrt/phases/fibre_extinction.h"

#include "pbrt/core/math.h"

// The table holds the quotient of sigma and the projected area of the ellipsoid that agrees along and across
// the fibre, sqrt(along^2 cos^2 + across^2 sin^2). It is 1 at both ends and nowhere below 0.95, so that
// interpolation has little to do.
//
//   angle:  v = sin^2 (1 + k) / (sin^2 + k), k = 4 s^2. For a small s all happens where the sine is about s.
//   width:  u = s^2 / (s^2 + 0.1). Quotients are smooth functions of s^2 near 0 and of 1/s^2 far out.
//
// The constants 4 and 0.1 are where polynomials of degree 5 on 32 equal steps were most accurate: 2e-8 each.

namespace lacquer {
namespace {

constexpr int kNumWidths = 32, kNumAngles = FibreExtinction::kNumAngles, kNumTaps = 6;
constexpr double kWidthScale = 0.1, kAngleScale = 4;

// C of the density of normals.
double NormalizationOf(double s) {
    return 1 / (2 * M_PI * std::sqrt(2 * M_PI) * s * std::erf(1 / (std::sqrt(2.) * s)));
}

// The mean |t.m|: the integral of |z| over the distribution of z = t.m, which is a cut-off Gaussian.
double AlongOf(double s) { return -4 * M_PI * NormalizationOf(s) * s * s * std::expm1(-0.5 / (s * s)); }

struct Table {
    float quotient[kNumWidths][kNumAngles];
    float across[kNumWidths];

    Table() {
        for (int i = 0; i < kNumWidths; ++i) {
            // The ends are needles and no order; the limits themselves have no quadrature.
            const double u = std::clamp(double(i) / (kNumWidths - 1), 1e-8, 1 - 1e-8);
            const double s2 = kWidthScale * u / (1 - u), s = std::sqrt(s2), k = kAngleScale * s2;
            const double along = AlongOf(s), widest = FibreProjectedArea(s, 1);
            across[i] = float(widest);
            for (int j = 0; j < kNumAngles; ++j) {
                const double v = double(j) / (kNumAngles - 1), sin2 = std::min(1., v * k / (1 + k - v));
                const double ellipsoid = std::sqrt(Sqr(along) * (1 - sin2) + Sqr(widest) * sin2);
                quotient[i][j] = float(FibreProjectedArea(s, std::sqrt(sin2)) / ellipsoid);
            }
        }
    }
};

const Table& SharedTable() {
    static const Table table;
    return table;
}

// Lagrange's polynomial through the six entries around x, for entries at 0 ... n-1.
struct Taps {
    int first;
    float weights[kNumTaps];
};
Taps TapsAt(float x, int n) {
    Taps taps;
    taps.first = std::clamp(int(x) - 2, 0, n - kNumTaps);
    const float t = x - float(taps.first);
    // Products of t - j over all j below and above each tap.
    float below[kNumTaps], above = 1;
    below[0] = 1;
    for (int j = 1; j < kNumTaps; ++j) below[j] = below[j - 1] * (t - float(j - 1));
    constexpr float kDenominators[kNumTaps] = {-120, 24, -12, 12, -24, 120};
    for (int j = kNumTaps - 1; j >= 0; --j) {
        taps.weights[j] = below[j] * above / kDenominators[j];
        above *= t - float(j);
    }
    return taps;
}

}  // namespace

double FibreProjectedArea(double s, double sinTheta) {
    // Around the fibre, for z = t.m fixed, |w.m| = |cosTheta z + sinTheta sqrt(1 - z^2) cos phi|. Where
    // |z| > sinTheta it has one sign and integrates to 2 pi cosTheta |z|, and that in closed form over z.
    const double cosTheta = std::sqrt(std::max(0., 1 - sinTheta * sinTheta));
    const double invVariance = 1 / (s * s);
    const double oneSign =
        2 * M_PI * cosTheta * s * s *
        (std::exp(-0.5 * sinTheta * sinTheta * invVariance) - std::exp(-0.5 * invVariance));

    // Elsewhere it is 4 (root + cosTheta z asin(..)); with z = sinTheta sin(psi) both are smooth. Beyond nine
    // standard deviations there is nothing.
    const double end = 9 * s < sinTheta ? std::asin(9 * s / sinTheta) : M_PI / 2;
    double sum = 0;
    constexpr double kStep = 0.08;
    for (int i = -40; i <= 40; ++i) {
        // Double exponential quadrature [Takahasi and Mori 1974].
        const double t = i * kStep, e = std::exp(M_PI * std::sinh(t));
        const double x = e / (1 + e), dx = M_PI * std::cosh(t) * e / Sqr(1 + e) * kStep;
        const double sinPsi = std::sin(end * x), cosPsi = std::cos(end * x), z = sinTheta * sinPsi;
        const double mean = 4 * (sinTheta * cosPsi + cosTheta * z * std::atan2(cosTheta * sinPsi, cosPsi));
        sum += std::exp(-0.5 * z * z * invVariance) * mean * sinTheta * cosPsi * end * dx;
    }
    return 2 * NormalizationOf(s) * (sum + oneSign);
}

FibreExtinction::FibreExtinction(float stddev)
    : stddev_(stddev < kMaxStddev ? std::max(stddev, kMinStddev) : kMaxStddev) {
    const float s2 = Sqr(stddev_), half = 0.5f / s2;
    normalization_ = 1 / (2 * Pi * std::sqrt(2 * Pi) * stddev_ * std::erf(std::sqrt(half)));
    along_ = -4 * Pi * normalization_ * s2 * std::expm1(-half);
    bend_ = float(kAngleScale) * s2;

    const Table& table = SharedTable();
    const Taps taps = TapsAt(s2 / (s2 + float(kWidthScale)) * (kNumWidths - 1), kNumWidths);
    across_ = 0;
    for (int i = 0; i < kNumTaps; ++i) {
        across_ += taps.weights[i] * table.across[taps.first + i];
        for (size_t j = 0; j < size_t(kNumAngles); ++j)
            row_[j] += taps.weights[i] * table.quotient[taps.first + i][j];
    }
}

float FibreExtinction::operator()(float sin2, float cos2) const {
    const float v = std::min(1.f, sin2 * (1 + bend_) / (sin2 + bend_));
    const Taps taps = TapsAt(v * (kNumAngles - 1), kNumAngles);
    float quotient = 0;
    const float* entries = row_.data() + taps.first;
    for (int i = 0; i < kNumTaps; ++i) quotient += taps.weights[i] * entries[i];
    return quotient * std::sqrt(Sqr(along_) * cos2 + Sqr(across_) * sin2);
}

}  // namespace lacquer
