#include "bulk/ensembles/structure.h"

#include <cmath>
#include <numbers>

namespace lacquer::bulk {

double PercusYevickStructureFactor(double volumeFraction, double qDiameter) {
    const double phi = volumeFraction, a = qDiameter;
    const double fourth = std::pow(1 - phi, 4);
    if (a < 0.05) return fourth / ((1 + 2 * phi) * (1 + 2 * phi));
    const double alpha = (1 + 2 * phi) * (1 + 2 * phi) / fourth;
    const double beta = -6 * phi * (1 + phi / 2) * (1 + phi / 2) / fourth;
    const double gamma = phi * alpha / 2;
    const double sine = std::sin(a), cosine = std::cos(a), a2 = a * a, a3 = a2 * a;
    const double transform =
        alpha / a2 * (sine - a * cosine) + beta / a3 * (2 * a * sine + (2 - a2) * cosine - 2) +
        gamma / (a2 * a3) * (-a2 * a2 * cosine + 4 * ((3 * a2 - 6) * cosine + (a3 - 6 * a) * sine + 6));
    return 1 / (1 + 24 * phi * transform / a);
}

double PercusYevickPairDistribution(double volumeFraction, double distance) {
    if (distance < 1) return 0;
    // Ornstein and Zernike: h - c is (S - 1)^2 / (rho S) in Fourier space, and c is 0 beyond the diameter.
    constexpr double kPi = std::numbers::pi, kEnd = 400, kStep = 0.02;
    const double density = 6 * volumeFraction / kPi;
    double sum = 0;
    for (double q = kStep / 2; q < kEnd; q += kStep) {
        const double s = PercusYevickStructureFactor(volumeFraction, q);
        sum += q * std::sin(q * distance) * (s - 1) * (s - 1) / s * kStep;
    }
    return 1 + sum / (2 * kPi * kPi * density * distance);
}

namespace {

double Sinc(double x) { return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x; }

}  // namespace

StructureSums::StructureSums(std::vector<double> wavenumbers, double binWidth, int numBins)
    : wavenumbers_(std::move(wavenumbers)),
      squares_(wavenumbers_.size(), 0.),
      means_(wavenumbers_.size(), 0.),
      meanSquares_(wavenumbers_.size(), 0.),
      binWidth_(binWidth),
      pairs_(size_t(numBins), 0.) {}

void StructureSums::Add(std::span<const Point> centers) {
    ++numRealizations_;
    numPoints_ += int64_t(centers.size());
    std::vector<double> squares(wavenumbers_.size(), double(centers.size())), sums(wavenumbers_.size(), 0.);
    for (size_t i = 0; i < centers.size(); ++i) {
        // Averaged over directions of q: sinc of a distance for each pair, and of the radius for the mean.
        const double radius = centers[i].norm();
        for (size_t k = 0; k < wavenumbers_.size(); ++k) sums[k] += Sinc(wavenumbers_[k] * radius);
        for (size_t j = i + 1; j < centers.size(); ++j) {
            const double distance = (centers[i] - centers[j]).norm();
            ++numPairs_;
            if (const double bin = distance / binWidth_; bin < double(pairs_.size())) ++pairs_[size_t(bin)];
            for (size_t k = 0; k < wavenumbers_.size(); ++k)
                squares[k] += 2 * Sinc(wavenumbers_[k] * distance);
        }
    }
    for (size_t k = 0; k < wavenumbers_.size(); ++k) {
        squares_[k] += squares[k];
        means_[k] += sums[k];
        meanSquares_[k] += sums[k] * sums[k];
    }
}

std::vector<double> StructureSums::StructureFactor() const {
    std::vector<double> s;
    const double count = numRealizations_;
    for (size_t k = 0; k < wavenumbers_.size(); ++k) {
        // Products of different realisations only: the square of a mean is biased by its variance.
        const double coherent =
            count > 1 ? (means_[k] * means_[k] - meanSquares_[k]) / (count * (count - 1)) : 0;
        s.push_back((squares_[k] / count - coherent) * count / double(numPoints_));
    }
    return s;
}

std::vector<double> StructureSums::PairDistribution(double radius) const {
    // Distances of two independent points in a ball: 3 t^2 (1 - 3t/4 + t^3/16) / R with t = r/R.
    const auto cumulative = [&](double r) {
        const double t = std::min(r / radius, 2.);
        return t * t * t * (1 - 9 * t / 16 + t * t * t / 32);
    };
    std::vector<double> g;
    for (size_t i = 0; i < pairs_.size(); ++i) {
        const double expected =
            numPairs_ * (cumulative(double(i + 1) * binWidth_) - cumulative(double(i) * binWidth_));
        g.push_back(expected > 0 ? pairs_[i] / expected : 0);
    }
    return g;
}

}  // namespace lacquer::bulk
