// Summaries "pyramid": statistics of oriented bands, octave by octave.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "estimate/fourier/fft.h"
#include "estimate/models/phases.h"
#include "estimate/summary/summary.h"
#include "pbrt/core/math.h"

namespace lacquer::estimate {
namespace {

constexpr int kOctaves = 4, kOrientations = 4;
/// Of the energy that noise has in a band: the variance of its magnitudes, 1 - pi / 4.
constexpr double kMagnitudeVariance = 0.2146;

/// A band of frequencies of one orientation, complex: frequencies of half of the plane only. Octave k is made
/// at the size that it needs, 2^-k of the image: its filter is 0 from the Nyquist frequency of that grid on.
struct Band {
    int size = 0;  ///< of the grid of this octave
    double cosine = 1, sine = 0;
    double floor = 0;  ///< energy of what rounding adds
    ComplexGrid values;
    std::vector<double> magnitudes;
    double mean = 0, meanSquare = 0, meanFourth = 0;
};

/// Sum of term(0) ... term(count - 1), eight at a time: in vectors, and in an order that does not depend on
/// where numbers lie in memory, as the reductions of Eigen's maps do.
template <class Term>
double SumOf(size_t count, const Term& term) {
    constexpr size_t kLanes = 8;
    std::array<double, kLanes> sums{};
    size_t i = 0;
    for (; i + kLanes <= count; i += kLanes)
        for (size_t lane = 0; lane < kLanes; ++lane) sums[lane] += term(i + lane);
    for (; i < count; ++i) sums[0] += term(i);
    return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

/// Magnitudes less their mean, and their standard deviation: what correlations compare.
struct Centered {
    std::vector<double> values;
    double sd = 1;

    /// @param floor  energy of what rounding adds to the band
    void Set(const std::vector<double>& magnitudes, double floor) {
        const size_t count = magnitudes.size();
        const double mean = SumOf(count, [&](size_t i) { return magnitudes[i]; }) / double(count);
        values.resize(count);
        for (size_t i = 0; i < count; ++i) values[i] = magnitudes[i] - mean;
        const double squares = SumOf(count, [&](size_t i) { return values[i] * values[i]; });
        sd = std::sqrt(squares / double(count) + kMagnitudeVariance * floor);
    }
    double Correlation(const Centered& other) const {
        const double* const a = values.data();
        const double* const b = other.values.data();
        const double sum = SumOf(values.size(), [&](size_t i) { return a[i] * b[i]; });
        return sum / (double(values.size()) * sd * other.sd);
    }
    /// Adds the derivatives by the magnitudes of this one.
    void CorrelationAdjoint(const Centered& other, double correlation, double by,
                            std::vector<double>* out) const {
        const double scale = by / (double(values.size()) * sd);
        // As sum of values is 0, taking the mean away has no derivative of its own here.
        for (size_t i = 0; i < values.size(); ++i)
            (*out)[i] += scale * (other.values[i] / other.sd - correlation * values[i] / sd);
    }
};

/// Every second magnitude along both directions, of those blurred by (1 2 1) / 4, periodic.
void Halve(int size, const std::vector<double>& in, std::vector<double>* out) {
    const size_t n = size_t(size), half = n / 2;
    out->resize(half * half);
    for (size_t i = 0; i < half; ++i) {
        const double* row = &in[2 * i * n];
        const double* above = &in[(2 * i + n - 1) % n * n];
        const double* below = &in[(2 * i + 1) * n];
        const auto blurred = [&](size_t left, size_t j) {
            const auto line = [&](const double* r) {
                return 0.25 * (r[left] + r[2 * j + 1]) + 0.5 * r[2 * j];
            };
            return 0.25 * (line(above) + line(below)) + 0.5 * line(row);
        };
        (*out)[i * half] = blurred(n - 1, 0);
        for (size_t j = 1; j < half; ++j) (*out)[i * half + j] = blurred(2 * j - 1, j);
    }
}
void HalveAdjoint(int size, const std::vector<double>& by, std::vector<double>* out) {
    const size_t n = size_t(size), half = n / 2;
    for (size_t i = 0; i < half; ++i) {
        const size_t rows[3] = {(2 * i + n - 1) % n, 2 * i, 2 * i + 1};
        for (size_t j = 0; j < half; ++j) {
            const size_t columns[3] = {(2 * j + n - 1) % n, 2 * j, 2 * j + 1};
            constexpr double kWeights[3] = {0.25, 0.5, 0.25};
            for (size_t a = 0; a < 3; ++a)
                for (size_t b = 0; b < 3; ++b)
                    (*out)[rows[a] * n + columns[b]] += kWeights[a] * kWeights[b] * by[i * half + j];
        }
    }
}

class PyramidSummary final : public Summary {
  public:
    explicit PyramidSummary(const MapGrid& grid)
        : size_(grid.size),
          fft_(grid.size),
          half_(fft_.MakeHalf()),
          image_(grid.NumPoints()),
          row_(size_t(grid.size)) {
        for (int octave = 0; octave < kOctaves; ++octave) {
            octaveFfts_.emplace_back(size_ >> octave);
            radial_.push_back(RadialFilter(octave));
            byBand_.emplace_back(size_ >> octave, size_ >> octave);
            for (int o = 0; o < kOrientations; ++o) {
                Band& band = bands_[size_t(octave * kOrientations + o)];
                band.size = size_ >> octave;
                band.cosine = std::cos(std::numbers::pi * o / kOrientations);
                band.sine = std::sin(std::numbers::pi * o / kOrientations);
                band.values = ComplexGrid(band.size, band.size);
                band.magnitudes.resize(size_t(band.size) * size_t(band.size));
                band.floor = kRoundingVariance * PowerOf(band, size_t(octave));
            }
        }
        MakeNames(grid);
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        // The mean has frequency 0, which no band has.
        fft_.Forward(input.luminance, &half_);
        for (size_t b = 0; b < bands_.size(); ++b) {
            Analyze(b);
            const Band& band = bands_[b];
            values[b] = 0.5 * std::log(band.meanSquare);
            values[bands_.size() + b] = std::log(band.meanFourth / (band.meanSquare * band.meanSquare));
            centered_[b].Set(band.magnitudes, band.floor);
        }
        for (size_t b = 0; b + kOrientations < bands_.size(); ++b) {
            Halve(bands_[b].size, bands_[b].magnitudes, &halved_);
            centeredHalf_[b].Set(halved_, bands_[b].floor);
        }
        size_t next = 2 * bands_.size();
        ForEachPair(
            [&](const Centered& a, const Centered& b, size_t, size_t) { values[next++] = a.Correlation(b); });
        const auto correlations = values.subspan(2 * bands_.size());
        correlations_.assign(correlations.begin(), correlations.end());
    }

    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        for (size_t b = 0; b < bands_.size(); ++b) {
            byMagnitudes_[b].assign(bands_[b].magnitudes.size(), 0.);
            if (b + kOrientations < bands_.size()) byHalf_[b].assign(centeredHalf_[b].values.size(), 0.);
        }
        size_t next = 0;
        ForEachPair([&](const Centered& a, const Centered& b, size_t ia, size_t ib) {
            const double c = correlations_[next], g = by[2 * bands_.size() + next++];
            a.CorrelationAdjoint(
                b, c, g, a.values.size() < bands_[ia].magnitudes.size() ? &byHalf_[ia] : &byMagnitudes_[ia]);
            b.CorrelationAdjoint(a, c, g, &byMagnitudes_[ib]);
        });
        ComplexGrid byHalfSpectrum = fft_.MakeHalf();
        for (size_t b = 0; b < bands_.size(); ++b) {
            if (b + kOrientations < bands_.size())
                HalveAdjoint(bands_[b].size, byHalf_[b], &byMagnitudes_[b]);
            BackwardBand(b, by[b], by[bands_.size() + b], &byHalfSpectrum);
        }
        fft_.ForwardAdjoint(&byHalfSpectrum, image_);
        for (size_t i = 0; i < image_.size(); ++i) byInput->luminance[i] += image_[i];
    }

  private:
    /// What a filter lets through at a frequency of its grid, without the orientation.
    std::vector<double> RadialFilter(int octave) const {
        const int n = size_ >> octave;
        const double middle = 0.25 * size_ / (1 << octave);  // cycles over the image
        std::vector<double> filter(size_t(n) * size_t(n));
        for (int row = 0; row < n; ++row)
            for (int column = 0; column < n; ++column) {
                const double k = std::hypot(SignedFrequency(row, n), SignedFrequency(column, n));
                const double octaves = k > 0 ? std::abs(std::log2(k / middle)) : 1;
                // Over k^3, as the filter of orientation has k^3 times the cube of a cosine; 2 for the other
                // half.
                filter[size_t(row) * size_t(n) + size_t(column)] =
                    octaves < 1 ? 2 * std::cos(std::numbers::pi / 2 * octaves) / (k * k * k) : 0;
            }
        return filter;
    }
    /// The parts of a row of frequencies that a band has: one for each column.
    std::span<const double> FilterRow(const Band& band, size_t octave, int row) const {
        const int n = band.size, ky = SignedFrequency(row, n);
        const double* radial = &radial_[octave][size_t(row) * size_t(n)];
        const auto fill = [&](int first, int end, int shift) {
            for (int column = first; column < end; ++column) {
                const double along = std::max(0., (column - shift) * band.cosine + ky * band.sine);
                row_[size_t(column)] = radial[column] * (along * along * along);
            }
        };
        fill(0, n / 2, 0);
        fill(n / 2, n, n);
        return {row_.data(), size_t(n)};
    }
    /// Part of the power of white noise that a band has.
    double PowerOf(const Band& band, size_t octave) const {
        double sum = 0;
        for (int row = 0; row < band.size; ++row)
            for (const double f : FilterRow(band, octave, row)) sum += f * f;
        return sum / (double(size_) * double(size_));
    }
    /// Where a row ky of a smaller grid begins in the half spectrum of the image.
    size_t HalfRow(int ky) const { return half_.Index(ky < 0 ? ky + size_ : ky, 0); }

    /// The band's part of the spectrum, at the size of its grid. A row at a time, and first its frequencies
    /// kx >= 0, which the half spectrum has, then those below, of which it has the conjugates.
    void FilterSpectrum(Band* band, size_t octave) const {
        const int n = band->size;
        const double scale = 1 / (double(size_) * double(size_));
        for (int row = 0; row < n; ++row) {
            const int ky = SignedFrequency(row, n);
            const auto filter = FilterRow(*band, octave, row);
            const double *re = &half_.re[HalfRow(ky)], *im = &half_.im[HalfRow(ky)];
            const double *conjugateRe = &half_.re[HalfRow(-ky)], *conjugateIm = &half_.im[HalfRow(-ky)];
            double* const toRe = &band->values.re[band->values.Index(row, 0)];
            double* const toIm = &band->values.im[band->values.Index(row, 0)];
            for (int column = 0; column < n / 2; ++column) {
                const double f = scale * filter[size_t(column)];
                toRe[column] = f * re[column];
                toIm[column] = f * im[column];
            }
            for (int column = n / 2; column < n; ++column) {
                const double f = scale * filter[size_t(column)];
                toRe[column] = f * conjugateRe[n - column];
                toIm[column] = -f * conjugateIm[n - column];
            }
        }
    }
    /// The adjoint: adds what a band's spectrum says to the half spectrum of the image.
    void FilterSpectrumAdjoint(const Band& band, size_t octave, const ComplexGrid& by,
                               ComplexGrid* byHalf) const {
        const int n = band.size;
        const double scale = 1 / (double(size_) * double(size_));
        for (int row = 0; row < n; ++row) {
            const int ky = SignedFrequency(row, n);
            const auto filter = FilterRow(band, octave, row);
            const double *re = &by.re[by.Index(row, 0)], *im = &by.im[by.Index(row, 0)];
            double *toRe = &byHalf->re[HalfRow(ky)], *toIm = &byHalf->im[HalfRow(ky)];
            for (int column = 0; column < n / 2; ++column) {
                const double f = scale * filter[size_t(column)];
                toRe[column] += f * re[column];
                toIm[column] += f * im[column];
            }
            toRe = &byHalf->re[HalfRow(-ky)], toIm = &byHalf->im[HalfRow(-ky)];
            for (int column = n / 2; column < n; ++column) {
                const double f = scale * filter[size_t(column)];
                toRe[n - column] += f * re[column];
                toIm[n - column] -= f * im[column];
            }
        }
    }

    void Analyze(size_t b) {
        Band& band = bands_[b];
        const size_t octave = b / kOrientations;
        FilterSpectrum(&band, octave);
        octaveFfts_[octave].InverseComplex(&band.values);
        double squares = 0, fourths = 0;
        const size_t n = size_t(band.size);
        for (size_t i = 0; i < n; ++i) {
            const size_t first = band.values.Index(int(i), 0);
            const double *re = &band.values.re[first], *im = &band.values.im[first];
            double* const magnitudes = &band.magnitudes[i * n];
            const auto square = [&](size_t j) { return re[j] * re[j] + im[j] * im[j] + band.floor; };
            for (size_t j = 0; j < n; ++j) magnitudes[j] = std::sqrt(square(j));
            squares += SumOf(n, square);
            fourths += SumOf(n, [&](size_t j) { return Sqr(square(j)); });
        }
        band.meanSquare = squares / double(n * n);
        band.meanFourth = fourths / double(n * n);
    }

    /// From magnitudes (in byMagnitudes_), energy and kurtosis to the half spectrum.
    void BackwardBand(size_t b, double byEnergy, double byKurtosis, ComplexGrid* byHalfSpectrum) {
        const Band& band = bands_[b];
        const size_t octave = b / kOrientations, n = size_t(band.size);
        ComplexGrid& by = byBand_[octave];
        const double count = double(n * n);
        const double bySquare = (0.5 * byEnergy / band.meanSquare - 2 * byKurtosis / band.meanSquare) / count;
        const double byFourth = byKurtosis / band.meanFourth / count;
        for (size_t i = 0; i < n; ++i) {
            const size_t first = band.values.Index(int(i), 0);
            for (size_t j = 0; j < n; ++j) {
                const double m = band.magnitudes[i * n + j];
                const double scale = byMagnitudes_[b][i * n + j] / m + 2 * bySquare + 4 * byFourth * m * m;
                by.re[first + j] = scale * band.values.re[first + j];
                by.im[first + j] = scale * band.values.im[first + j];
            }
        }
        octaveFfts_[octave].ForwardComplex(&by);
        FilterSpectrumAdjoint(band, octave, by, byHalfSpectrum);
    }

    /// Pairs of orientations of an octave, and of the same orientation in an octave and the next.
    template <class Visit>
    void ForEachPair(const Visit& visit) const {
        for (size_t a = 0; a < bands_.size(); ++a) {
            const size_t end = (a / kOrientations + 1) * kOrientations;
            for (size_t b = a + 1; b < end; ++b) visit(centered_[a], centered_[b], a, b);
            if (a + kOrientations < bands_.size())
                visit(centeredHalf_[a], centered_[a + kOrientations], a, a + kOrientations);
        }
    }

    void MakeNames(const MapGrid& grid) {
        const auto name = [&](size_t b) {
            return fmt::format("{:.3g} cycles/cm at {} degrees",
                               0.25 * size_ / double(1 << (b / kOrientations)) / grid.extent,
                               180 * (b % kOrientations) / kOrientations);
        };
        for (size_t b = 0; b < bands_.size(); ++b) names_.push_back("energy of " + name(b));
        for (size_t b = 0; b < bands_.size(); ++b) names_.push_back("sparsity of " + name(b));
        ForEachPair([&](const Centered&, const Centered&, size_t a, size_t b) {
            names_.push_back("correlation of " + name(a) + " and " + name(b));
        });
    }

    int size_;
    Fft2 fft_;
    ComplexGrid half_;
    std::vector<Fft2> octaveFfts_;
    std::vector<std::vector<double>> radial_;
    std::vector<ComplexGrid> byBand_;  ///< for each octave
    std::array<Band, kOctaves * kOrientations> bands_;
    std::array<Centered, kOctaves * kOrientations> centered_, centeredHalf_;
    std::array<std::vector<double>, kOctaves * kOrientations> byMagnitudes_, byHalf_;
    std::vector<double> correlations_, image_, halved_;
    mutable std::vector<double> row_;  ///< of FilterRow
};

}  // namespace

std::unique_ptr<Summary> MakePyramidSummary(const MapGrid& grid) {
    return std::make_unique<PyramidSummary>(grid);
}

}  // namespace lacquer::estimate
