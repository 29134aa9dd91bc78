#include "materialgan/procedural/fractal_noise.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "pbrt/core/check.h"

namespace lacquer::materialgan {
namespace {

using Complex = std::complex<double>;

/// The sum over frequencies, in place [Cooley and Tukey 1965]: `count` numbers, `stride` apart.
void SumFrequencies(Complex* x, size_t count, size_t stride) {
    for (size_t i = 1, j = 0; i < count; ++i) {
        size_t bit = count >> 1;
        for (; j & bit; bit >>= 1) j ^= bit;
        j ^= bit;
        if (i < j) std::swap(x[i * stride], x[j * stride]);
    }
    for (size_t length = 2; length <= count; length *= 2) {
        const Complex turn = std::polar(1., 2 * std::numbers::pi / double(length));
        for (size_t begin = 0; begin < count; begin += length) {
            Complex factor = 1;
            for (size_t k = 0; k < length / 2; ++k, factor *= turn) {
                Complex& a = x[(begin + k) * stride];
                Complex& b = x[(begin + k + length / 2) * stride];
                const Complex odd = b * factor;
                b = a - odd;
                a += odd;
            }
        }
    }
}

}  // namespace

double UniformIn(Rng& rng, double low, double high) { return low + (high - low) * double(rng.Uniform()); }

int WholeIn(Rng& rng, int low, int high) { return low + int(rng.UniformInt(uint32_t(high - low + 1))); }

double StandardNormal(Rng& rng) {
    // [Box and Muller 1958]
    const double radius = std::sqrt(-2 * std::log(1 - double(rng.Uniform())));
    return radius * std::cos(2 * std::numbers::pi * double(rng.Uniform()));
}

Field FractalNoise(int size, double exponent, double stretchX, Rng& rng) {
    LACQUER_CHECK(size > 0 && (size & (size - 1)) == 0);
    const auto n = size_t(size);
    std::vector<Complex> spectrum(n * n);
    for (size_t row = 0; row < n; ++row)
        for (size_t column = 0; column < n; ++column) {
            // Frequencies from -n/2 to n/2.
            const double v = double(row) - (row > n / 2 ? double(n) : 0.);
            const double u = (double(column) - (column > n / 2 ? double(n) : 0.)) * stretchX;
            const double frequency = std::sqrt(u * u + v * v),
                         phase = 2 * std::numbers::pi * double(rng.Uniform());
            const double length = std::sqrt(-2 * std::log(1 - double(rng.Uniform())));
            if (frequency > 0)
                spectrum[row * n + column] = std::polar(length * std::pow(frequency, -exponent), phase);
        }
    for (size_t row = 0; row < n; ++row) SumFrequencies(&spectrum[row * n], n, 1);
    for (size_t column = 0; column < n; ++column) SumFrequencies(&spectrum[column], n, n);
    // Without the zero frequency the mean is 0.
    double squares = 0;
    for (const Complex& z : spectrum) squares += z.real() * z.real();
    const double scale = 1 / std::sqrt(squares / double(n * n) + 1e-18);
    Field field(n * n);
    for (size_t i = 0; i < field.size(); ++i) field[i] = spectrum[i].real() * scale;
    return field;
}

}  // namespace lacquer::materialgan
