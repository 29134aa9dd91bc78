#include "bulk/mie/mie.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

/// D_n = psi_n'/psi_n of z for n = 0 ... degree, by recurrence downwards.
std::vector<Complex> LogDerivatives(Complex z, int degree) {
    const double size = std::abs(z);
    const int start = int(std::max(double(degree), size) + 4.05 * std::cbrt(size) + 16);
    std::vector<Complex> d(size_t(degree) + 1);
    Complex next = 0;
    for (int n = start; n > 0; --n) {
        const Complex ratio = double(n) / z;
        next = ratio - 1. / (next + ratio);
        if (n - 1 <= degree) d[size_t(n - 1)] = next;
    }
    return d;
}

/// Riccati-Bessel functions of a real argument, n = 0 ... degree.
struct RiccatiBessel {
    std::vector<double> psi, chi;  ///< x j_n and -x y_n
    Complex Xi(size_t n) const { return {psi[n], -chi[n]}; }
};

RiccatiBessel RiccatiBesselOf(double x, int degree) {
    const std::vector<Complex> d = LogDerivatives(x, degree);
    const size_t size = size_t(degree) + 1;
    RiccatiBessel f{std::vector<double>(size), std::vector<double>(size)};
    // Upwards as far as that is stable, to n = x; beyond it by psi_n / psi_{n-1} = 1 / (D_n + n/x), where no
    // psi_n is zero.
    f.psi[0] = std::sin(x);
    for (size_t n = 1; n < size; ++n)
        f.psi[n] = double(n) > x ? f.psi[n - 1] / (d[n].real() + double(n) / x)
                   : n == 1      ? f.psi[0] / x - std::cos(x)
                                 : double(2 * n - 1) / x * f.psi[n - 1] - f.psi[n - 2];
    f.chi[0] = std::cos(x);
    if (degree >= 1) f.chi[1] = std::cos(x) / x + std::sin(x);
    for (size_t n = 1; n + 1 < size; ++n) f.chi[n + 1] = double(2 * n + 1) / x * f.chi[n] - f.chi[n - 1];
    return f;
}

/// What a sphere does to waves of degree n outside, by the logarithmic derivatives inside [Yang 2003, eq.
/// 24-25].
MieCoefficients FromInside(double x, Complex outerIndex, std::span<const Complex> electric,
                           std::span<const Complex> magnetic, int degree) {
    const RiccatiBessel f = RiccatiBesselOf(x, degree);
    MieCoefficients result{std::vector<Complex>(size_t(degree)), std::vector<Complex>(size_t(degree))};
    for (size_t n = 1; n <= size_t(degree); ++n) {
        if (!std::isfinite(f.chi[n])) break;  // far beyond what the sphere scatters: zero
        const auto coefficient = [&](Complex derivative) {
            const Complex sum = derivative + double(n) / x;
            return (sum * f.psi[n] - f.psi[n - 1]) / (sum * f.Xi(n) - f.Xi(n - 1));
        };
        result.a[n - 1] = coefficient(electric[n] / outerIndex);
        result.b[n - 1] = coefficient(magnetic[n] * outerIndex);
    }
    return result;
}

/// Functions of a layer's complex argument z = a + ib, n = 0 ... degree: logarithmic derivatives, and psi/xi
/// without its factor e^{2b}.
struct LayerFunctions {
    std::vector<Complex> psiDerivative, xiDerivative, ratio;
};

LayerFunctions LayerFunctionsOf(Complex z, int degree) {
    const size_t size = size_t(degree) + 1;
    LayerFunctions f{LogDerivatives(z, degree), std::vector<Complex>(size), std::vector<Complex>(size)};
    const Complex i(0, 1), wave = std::exp(i * z.real());
    const double decay = std::exp(-2 * z.imag());
    // psi e^{-b} by ratios as above, xi e^b upwards, where it grows.
    Complex psi = (wave * decay - std::conj(wave)) / (2. * i), xi = -i * wave, xiBefore = 0;
    const Complex psi1 = psi / z - 0.5 * (wave * decay + std::conj(wave));
    const bool fromPsi1 = std::abs(z) > 1 && std::abs(psi) < 0.1;
    f.xiDerivative[0] = i;
    f.ratio[0] = psi / xi;
    for (size_t n = 1; n < size; ++n) {
        const Complex over = double(n) / z;
        psi = n == 1 && fromPsi1 ? psi1 : psi / (f.psiDerivative[n] + over);
        const Complex xiNext = n == 1 ? xi * (1. / z - i) : double(2 * n - 1) / z * xi - xiBefore;
        // Beyond the range of numbers: psi/xi vanishes, and with it what is below this boundary.
        if (!std::isfinite(std::norm(xiNext))) {
            for (size_t rest = n; rest < size; ++rest) f.xiDerivative[rest] = -double(rest) / z;
            break;
        }
        xiBefore = std::exchange(xi, xiNext);
        f.xiDerivative[n] = xiBefore / xi - over;
        f.ratio[n] = psi / xi;
    }
    return f;
}

}  // namespace

int MieDegree(double x) {
    const double root = std::cbrt(x);
    const double degree = x <= 8 ? x + 4 * root + 1 : x < 4200 ? x + 4.05 * root + 2 : x + 4 * root + 2;
    return x < 0.02 ? 3 : std::max(3, int(std::ceil(degree)));
}

int FieldDegree(double radius, double digits) {
    return std::max(3, int(std::ceil(radius + 1.8 * std::cbrt(digits * digits * radius) + 2)));
}

MieCoefficients MieOfSphere(double x, Complex m, int degree) {
    LACQUER_CHECK(x > 0 && degree >= 1 && std::abs(m) > 0);
    const std::vector<Complex> d = LogDerivatives(m * x, degree);
    return FromInside(x, m, d, d, degree);
}

MieCoefficients MieOfLayers(std::span<const SphereLayer> layers, int degree) {
    LACQUER_CHECK(!layers.empty() && layers[0].x > 0 && degree >= 1);
    // Logarithmic derivatives below each boundary, from the core outwards [Yang 2003].
    std::vector<Complex> electric = LogDerivatives(layers[0].index * layers[0].x, degree),
                         magnetic = electric;
    for (size_t l = 1; l < layers.size(); ++l) {
        const Complex m0 = layers[l - 1].index, m1 = layers[l].index;
        const Complex z1 = m1 * layers[l - 1].x, z2 = m1 * layers[l].x;
        const LayerFunctions inner = LayerFunctionsOf(z1, degree), outer = LayerFunctionsOf(z2, degree);
        const double growth = std::exp(2 * (z1.imag() - z2.imag()));
        for (size_t n = 1; n <= size_t(degree); ++n) {
            const Complex q = growth * inner.ratio[n] / outer.ratio[n];
            // psi and xi of this layer, joined so that they continue what is below.
            const auto join = [&](Complex below, Complex weightBelow, Complex weightHere) {
                const Complex g1 = weightBelow * below - weightHere * inner.psiDerivative[n];
                const Complex g2 = weightBelow * below - weightHere * inner.xiDerivative[n];
                return (g2 * outer.psiDerivative[n] - q * g1 * outer.xiDerivative[n]) / (g2 - q * g1);
            };
            electric[n] = join(electric[n], m1, m0);
            magnetic[n] = join(magnetic[n], m0, m1);
        }
    }
    return FromInside(layers.back().x, layers.back().index, electric, magnetic, degree);
}

MieEfficiencies EfficienciesOf(const MieCoefficients& coefficients, double x) {
    const auto& [a, b] = coefficients;
    MieEfficiencies q;
    Complex back = 0;
    double cosines = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double n = double(i + 1), weight = 2 * n + 1;
        q.extinction += weight * (a[i] + b[i]).real();
        q.scattering += weight * (std::norm(a[i]) + std::norm(b[i]));
        back += weight * ParitySign(int(i + 1)) * (a[i] - b[i]);
        cosines += weight / (n * (n + 1)) * (a[i] * std::conj(b[i])).real();
        if (i + 1 < a.size())
            cosines +=
                n * (n + 2) / (n + 1) * (a[i] * std::conj(a[i + 1]) + b[i] * std::conj(b[i + 1])).real();
    }
    q.g = q.scattering > 0 ? 2 * cosines / q.scattering : 0;
    const double scale = 2 / (x * x);
    q.extinction *= scale;
    q.scattering *= scale;
    q.backscattering = std::norm(back) / (x * x);
    return q;
}

MieAmplitudes AmplitudesAt(const MieCoefficients& coefficients, double cosTheta) {
    MieAmplitudes s;
    double piBefore = 0, pi = 1;
    for (size_t i = 0; i < coefficients.a.size(); ++i) {
        const double n = double(i + 1);
        const double tau = n * cosTheta * pi - (n + 1) * piBefore;
        const double weight = (2 * n + 1) / (n * (n + 1));
        s.s1 += weight * (coefficients.a[i] * pi + coefficients.b[i] * tau);
        s.s2 += weight * (coefficients.a[i] * tau + coefficients.b[i] * pi);
        const double next = ((2 * n + 1) * cosTheta * pi - (n + 1) * piBefore) / n;
        piBefore = pi;
        pi = next;
    }
    return s;
}

}  // namespace lacquer::bulk
