#include "bulk/cluster/far_field.h"

#include <cmath>
#include <numbers>

#include "bulk/waves/harmonics.h"
#include "bulk/waves/regular_translation.h"
#include "pbrt/core/check.h"

namespace lacquer::bulk {
namespace {

/// Coefficients of e^{im phi} of a 2x2 matrix, m = -degree ... degree.
using Fourier = std::vector<Eigen::Matrix2cd>;

/// Of F at one polar angle; column x, column y.
Fourier AmplitudeFourier(const OneOriginWaves& waves, const Eigen::Matrix2Xcd& field, int fieldDegree) {
    const int size = NumHarmonics(waves.degree), fieldSize = NumHarmonics(fieldDegree);
    Fourier f(size_t(2 * waves.degree + 1), Eigen::Matrix2cd::Zero());
    for (int n = 1; n <= waves.degree; ++n)
        for (int m = -n; m <= n; ++m) {
            const int i = HarmonicIndex(n, m);
            f[size_t(m + waves.degree)] += field.col(i) * waves.coefficients.row(i) +
                                           field.col(fieldSize + i) * waves.coefficients.row(size + i);
        }
    return f;
}

/// From incident x and y to incident fields in the scattering plane and perpendicular to it: columns
/// F_x cos phi + F_y sin phi and F_y cos phi - F_x sin phi; m = -degree - 1 ... degree + 1.
Fourier InScatteringPlane(const Fourier& f) {
    const Complex i(0, 1);
    Fourier g(f.size() + 2, Eigen::Matrix2cd::Zero());
    for (size_t m = 0; m < f.size(); ++m) {
        const Eigen::Vector2cd up = 0.5 * (f[m].col(0) - i * f[m].col(1));
        const Eigen::Vector2cd down = 0.5 * (f[m].col(0) + i * f[m].col(1));
        g[m + 2].col(0) += up;
        g[m + 2].col(1) += i * up;
        g[m].col(0) += down;
        g[m].col(1) -= i * down;
    }
    return g;
}

AzimuthalMeans MeansOf(const Fourier& g) {
    AzimuthalMeans means;
    means.amplitude = g[g.size() / 2];
    for (const Eigen::Matrix2cd& term : g) {
        // By Parseval's theorem. F = i S; indices as in [Bohren and Huffman 1983, eq. 3.12].
        const Complex s2 = term(0, 0), s3 = term(0, 1), s4 = term(1, 0), s1 = term(1, 1);
        const double n1 = std::norm(s1), n2 = std::norm(s2), n3 = std::norm(s3), n4 = std::norm(s4);
        means.s11 += 0.5 * (n1 + n2 + n3 + n4);
        means.s12 += 0.5 * (n2 - n1);
        means.s22 += 0.5 * (n1 + n2 - n3 - n4);
        const Complex same = s1 * std::conj(s2), crossed = s3 * std::conj(s4);
        means.s33 += (same + crossed).real();
        means.s34 -= same.imag();
        means.s44 += (same - crossed).real();
    }
    return means;
}

}  // namespace

Eigen::Matrix2cd OneOriginWaves::Amplitude(Direction s) const { return FarField(degree, s) * coefficients; }

// With coefficients p of M_nm and q of N_nm, F is the sum over n, m of (-i)^n sqrt((2n + 1)/4 pi) exp(i m
// phi)
// [-(p + q)/2 d^n_{m,1} (theta^ + i phi^) + (q - p)/2 d^n_{m,-1} (theta^ - i phi^)]: two sums of orthonormal
// functions, whose products with cos theta = d^1_{00} and sin theta exp(i phi) = -sqrt(2) d^1_{10} exp(i phi)
// are those of degrees n - 1, n, n + 1 by Clebsch-Gordan coefficients [Varshalovich et al. 1988, sec. 4.6.1].
CrossSection OneOriginWaves::Asymmetry(Direction n) const {
    const Eigen::Index size = NumHarmonics(degree);
    Eigen::Array2cd along = Eigen::Array2cd::Zero(), across = Eigen::Array2cd::Zero();
    for (const int spin : {1, -1}) {
        const auto wave = [&](int l, int m) -> Eigen::Vector2cd {
            const Eigen::Index i = HarmonicIndex(l, m);
            return PowerOfI(-l) * (coefficients.row(i) + double(spin) * coefficients.row(size + i));
        };
        const auto product = [](const Eigen::Vector2cd& a, const Eigen::Vector2cd& b) -> Eigen::Array2cd {
            return a.conjugate().array() * b.array();
        };
        for (int l = 1; l <= degree; ++l)
            for (int m = -l; m <= l; ++m) {
                const Eigen::Vector2cd c = wave(l, m);
                const double same = spin / (l * (l + 1.));
                along += m * same * product(c, c);
                if (m < l) across += std::sqrt((l - m) * (l + m + 1.)) * same * product(wave(l, m + 1), c);
                if (l == degree) continue;
                // Of (l, m) and (l + 1, ...), but for the factor of m.
                const double next = std::sqrt(l * (l + 2.) / ((2 * l + 1.) * (2 * l + 3.))) / (l + 1);
                along += 2 * next * std::sqrt((l + 1. - m) * (l + 1. + m)) * product(wave(l + 1, m), c);
                across += next * (std::sqrt((l - m + 1.) * (l - m + 2.)) * product(c, wave(l + 1, m - 1)) -
                                  std::sqrt((l + m + 1.) * (l + m + 2.)) * product(wave(l + 1, m + 1), c));
            }
    }
    return 0.5 * (std::cos(n.theta) * along + std::polar(std::sin(n.theta), -n.phi) * across).real();
}

int FarFieldDegree(double radius, int degree) {
    constexpr double kDigits = 12;
    return std::max(degree, FieldDegree(radius, kDigits));
}

int FarFieldDegree(const Cluster& cluster) { return FarFieldDegree(cluster.Radius(), cluster.Degree()); }

OneOriginWaves AboutOrigin(const Cluster& cluster, const HelicityWaves& scattered, int degree) {
    return AboutOrigin(cluster, {&scattered, 1}, degree)[0];
}

std::vector<OneOriginWaves> AboutOrigin(const Cluster& cluster, std::span<const HelicityWaves> scattered,
                                        int degree) {
    LACQUER_CHECK(degree >= cluster.Degree());
    const auto numColumns = 2 * Eigen::Index(scattered.size());
    double farthest = 0;
    for (int i = 0; i < cluster.NumSpheres(); ++i) farthest = std::max(farthest, cluster.At(i).center.norm());
    const RegularTranslation toOrigin(cluster.Degree(), degree, farthest);
    Eigen::MatrixXcd sum = Eigen::MatrixXcd::Zero(2 * NumHarmonics(degree), numColumns);
    for (int i = 0; i < cluster.NumSpheres(); ++i) {
        Eigen::MatrixXcd each(2 * NumHarmonics(cluster.Degree()), numColumns);
        for (size_t k = 0; k < scattered.size(); ++k)
            each.middleCols(2 * Eigen::Index(k), 2) = scattered[k].Get(i);
        sum += toOrigin.Apply(-cluster.At(i).center, each);
    }
    std::vector<OneOriginWaves> waves;
    for (size_t k = 0; k < scattered.size(); ++k)
        waves.push_back({degree, sum.middleCols(2 * Eigen::Index(k), 2)});
    return waves;
}

AzimuthalHarmonics::AzimuthalHarmonics(int degree, std::span<const double> thetas) : degree_(degree) {
    for (const double theta : thetas) fields_.push_back(FarField(degree, {theta, 0}));
}

std::vector<AzimuthalMeans> AzimuthalMeansOf(const OneOriginWaves& waves,
                                             const AzimuthalHarmonics& harmonics) {
    LACQUER_CHECK(waves.degree <= harmonics.Degree());
    std::vector<AzimuthalMeans> means;
    for (int i = 0; i < harmonics.NumAngles(); ++i)
        means.push_back(
            MeansOf(InScatteringPlane(AmplitudeFourier(waves, harmonics.At(i), harmonics.Degree()))));
    return means;
}

EvenAzimuths::EvenAzimuths(int degree, int count) : cosines_(degree + 1, count), sines_(degree + 1, count) {
    LACQUER_CHECK(count >= 2);
    for (int k = 0; k < count; ++k)
        for (int m = 0; m <= degree; ++m) {
            const double angle = m * k * std::numbers::pi / (count - 1);
            cosines_(m, k) = std::cos(angle);
            sines_(m, k) = std::sin(angle);
        }
}

Eigen::VectorXd IntensityAround(const OneOriginWaves& waves, const AzimuthalHarmonics& harmonics, int i,
                                const EvenAzimuths& azimuths) {
    LACQUER_CHECK(waves.degree <= std::min(harmonics.Degree(), azimuths.Degree()));
    const Fourier f = AmplitudeFourier(waves, harmonics.At(i), harmonics.Degree());
    // F(phi) = E + i O and F(-phi) = E - i O. Real and imaginary parts, so that products are of real numbers.
    Eigen::MatrixXd even(8, waves.degree + 1), odd(8, waves.degree + 1);
    const auto store = [](const Eigen::Matrix2cd& terms, Eigen::MatrixXd* parts, int m) {
        for (int k = 0; k < 4; ++k) {
            (*parts)(k, m) = terms(k / 2, k % 2).real();
            (*parts)(4 + k, m) = terms(k / 2, k % 2).imag();
        }
    };
    for (int m = 0; m <= waves.degree; ++m) {
        const Eigen::Matrix2cd &up = f[size_t(waves.degree + m)], &down = f[size_t(waves.degree - m)];
        store(m == 0 ? up : Eigen::Matrix2cd(up + down), &even, m);
        store(up - down, &odd, m);
    }
    const Eigen::Index rows = waves.degree + 1;
    const Eigen::MatrixXd e = even * azimuths.Cosines().topRows(rows),
                          o = odd * azimuths.Sines().topRows(rows);
    return 0.5 * (e.colwise().squaredNorm() + o.colwise().squaredNorm()).transpose();
}

}  // namespace lacquer::bulk
