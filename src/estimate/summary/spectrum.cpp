// Summaries "spectrum" and "columnspectrum": half the log of mean powers.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimate/fourier/fft.h"
#include "estimate/models/phases.h"
#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

constexpr double kLowest = 1.5;  ///< cycles per image, where the first band begins
/// Mean square of a Hann window: what is left of the power of noise.
constexpr double kWindowPower = 3. / 8;

/// Band of a frequency in cycles per image, of `count` with equal ratios up to the Nyquist frequency; -1 for
/// none.
int BandOf(double frequency, int size, int count) {
    if (frequency < kLowest || frequency >= 0.5 * size) return -1;
    const int band = int(std::log(frequency / kLowest) / std::log(0.5 * size / kLowest) * count);
    return std::min(band, count - 1);
}
/// Frequency in the middle of a band, in cycles per cm.
double MiddleOf(int band, const MapGrid& grid, int count) {
    return kLowest * std::pow(0.5 * grid.size / kLowest, (band + 0.5) / count) / grid.extent;
}

std::vector<double> HannWindow(int size) {
    std::vector<double> window;
    for (int i = 0; i < size; ++i)
        window.push_back(0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 1) / (size + 1)));
    return window;
}

class SpectrumSummary final : public Summary {
  public:
    explicit SpectrumSummary(const MapGrid& grid)
        : size_(grid.size),
          window_(HannWindow(grid.size)),
          fft_(grid.size),
          half_(fft_.MakeHalf()),
          band_(half_.re.size(), -1),
          weights_(kBands * kSectors),
          powers_(kBands * kSectors),
          windowed_(grid.NumPoints()) {
        const char* directions[kSectors] = {"across columns", "across rows"};
        for (int band = 0; band < kBands; ++band)
            for (int sector = 0; sector < kSectors; ++sector)
                names_.push_back(fmt::format("energy at {:.3g} cycles/cm {}", MiddleOf(band, grid, kBands),
                                             directions[sector]));
        for (int row = 0; row < half_.rows; ++row)
            for (int kx = 0; kx < half_.columns; ++kx) {
                const double ky = SignedFrequency(row, size_);
                const int band = BandOf(std::hypot(ky, kx), size_, kBands);
                if (band < 0) continue;
                // Sector 0 within 45 degrees of the x axis.
                const int index = band * kSectors + (std::abs(ky) > kx ? 1 : 0);
                band_[half_.Index(row, kx)] = index;
                weights_[size_t(index)] += 1;
            }
        const double scale = 1 / (double(size_) * double(size_));
        for (double& w : weights_) w = w > 0 ? scale / w : 0;
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        const size_t n = size_t(size_);
        double sum = 0;
        for (const double v : input.luminance) sum += v;
        const double mean = sum / double(n * n);
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j < n; ++j)
                windowed_[i * n + j] = (input.luminance[i * n + j] - mean) * window_[i] * window_[j];
        fft_.Forward(windowed_, &half_);
        std::fill(powers_.begin(), powers_.end(), 0.);
        for (size_t i = 0; i < band_.size(); ++i)
            if (band_[i] >= 0)
                powers_[size_t(band_[i])] += half_.re[i] * half_.re[i] + half_.im[i] * half_.im[i];
        for (size_t k = 0; k < powers_.size(); ++k) {
            powers_[k] = powers_[k] * weights_[k] + kWindowPower * kWindowPower * kRoundingVariance;
            values[k] = 0.5 * std::log(powers_[k]);
        }
    }

    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        ComplexGrid byHalf = half_;
        for (size_t i = 0; i < band_.size(); ++i) {
            const size_t k = size_t(std::max(band_[i], 0));
            const double scale = band_[i] < 0 ? 0 : by[k] * weights_[k] / powers_[k];
            byHalf.re[i] *= scale;
            byHalf.im[i] *= scale;
        }
        fft_.ForwardAdjoint(&byHalf, windowed_);
        const size_t n = size_t(size_);
        double sum = 0;
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j < n; ++j) sum += windowed_[i * n + j] *= window_[i] * window_[j];
        const double mean = sum / double(n * n);
        for (size_t i = 0; i < n * n; ++i) byInput->luminance[i] += windowed_[i] - mean;
    }

  private:
    static constexpr int kBands = 8, kSectors = 2;
    int size_;
    std::vector<double> window_;
    Fft2 fft_;
    ComplexGrid half_;
    std::vector<int> band_;  ///< of each entry of the half spectrum
    std::vector<double> weights_, powers_, windowed_;
};

/// Spectra of the columns of an image, or of its rows, in groups of neighbours.
class LineSpectra {
  public:
    LineSpectra(int size, int bands, bool alongRows)
        : size_(size),
          alongRows_(alongRows),
          window_(HannWindow(size)),
          fft_(size),
          grid_(size, size),
          weights_(size_t(bands)),
          powers_(size_t(bands * kGroups)) {
        for (int k = 0; k <= size / 2; ++k) {
            band_.push_back(BandOf(k, size, bands));
            if (band_.back() >= 0) weights_[size_t(band_.back())] += 1;
        }
        for (double& w : weights_) w = w > 0 ? 1 / (w * double(size) * double(size / kGroups)) : 0;
    }

    static constexpr int kGroups = 4;

    void Forward(std::span<const double> luminance, std::span<double> values) {
        const size_t n = size_t(size_);
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j < n; ++j) grid_.re[grid_.Index(int(i), int(j))] = luminance[Pixel(i, j)];
        std::fill(grid_.im.begin(), grid_.im.end(), 0.);
        for (size_t j = 0; j < n; ++j) {
            double sum = 0;
            for (size_t i = 0; i < n; ++i) sum += grid_.re[grid_.Index(int(i), int(j))];
            for (size_t i = 0; i < n; ++i) {
                double& v = grid_.re[grid_.Index(int(i), int(j))];
                v = (v - sum / double(n)) * window_[i];
            }
        }
        fft_.Forward(&grid_);
        std::fill(powers_.begin(), powers_.end(), 0.);
        for (size_t k = 0; k < band_.size(); ++k)
            for (size_t j = 0; band_[k] >= 0 && j < n; ++j) {
                const size_t i = grid_.Index(int(k), int(j));
                powers_[Place(band_[k], j)] += grid_.re[i] * grid_.re[i] + grid_.im[i] * grid_.im[i];
            }
        for (size_t p = 0; p < powers_.size(); ++p) {
            powers_[p] = powers_[p] * weights_[p / kGroups] + kWindowPower * kRoundingVariance;
            values[p] = 0.5 * std::log(powers_[p]);
        }
    }

    void Backward(std::span<const double> by, std::span<double> byLuminance) {
        const size_t n = size_t(size_);
        ComplexGrid g(size_, size_);
        for (size_t k = 0; k < band_.size(); ++k)
            for (size_t j = 0; band_[k] >= 0 && j < n; ++j) {
                const size_t i = grid_.Index(int(k), int(j)), p = Place(band_[k], j);
                const double scale = by[p] * weights_[p / kGroups] / powers_[p];
                g.re[i] = scale * grid_.re[i];
                g.im[i] = scale * grid_.im[i];
            }
        fft_.Inverse(&g);
        for (size_t j = 0; j < n; ++j) {
            double sum = 0;
            for (size_t i = 0; i < n; ++i) sum += g.re[g.Index(int(i), int(j))] *= window_[i];
            for (size_t i = 0; i < n; ++i)
                byLuminance[Pixel(i, j)] += g.re[g.Index(int(i), int(j))] - sum / double(n);
        }
    }

  private:
    /// Sample i of line j.
    size_t Pixel(size_t i, size_t j) const {
        return alongRows_ ? j * size_t(size_) + i : i * size_t(size_) + j;
    }
    size_t Place(int band, size_t line) const {
        return size_t(band) * kGroups + std::min(line * kGroups / size_t(size_), size_t(kGroups - 1));
    }

    int size_;
    bool alongRows_;
    std::vector<double> window_;
    FftColumns fft_;
    ComplexGrid grid_;
    std::vector<int> band_;
    std::vector<double> weights_, powers_;
};

class ColumnSpectrumSummary final : public Summary {
  public:
    explicit ColumnSpectrumSummary(const MapGrid& grid)
        : bands_(grid.size >= 256 ? 8 : 6),
          columns_(grid.size, bands_, false),
          rows_(grid.size, bands_, true) {
        for (const char* line : {"columns", "rows"})
            for (int band = 0; band < bands_; ++band)
                for (int group = 0; group < LineSpectra::kGroups; ++group)
                    names_.push_back(fmt::format("energy at {:.3g} cycles/cm along {} of quarter {}",
                                                 MiddleOf(band, grid, bands_), line, group + 1));
    }
    void Forward(const SummaryInput& input, std::span<double> values) override {
        columns_.Forward(input.luminance, values.first(Size() / 2));
        rows_.Forward(input.luminance, values.last(Size() / 2));
    }
    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        columns_.Backward(by.first(Size() / 2), byInput->luminance);
        rows_.Backward(by.last(Size() / 2), byInput->luminance);
    }

  private:
    int bands_;
    LineSpectra columns_, rows_;
};

}  // namespace

std::unique_ptr<Summary> MakeSpectrumSummary(const MapGrid& grid) {
    return std::make_unique<SpectrumSummary>(grid);
}
std::unique_ptr<Summary> MakeColumnSpectrumSummary(const MapGrid& grid) {
    return std::make_unique<ColumnSpectrumSummary>(grid);
}

}  // namespace lacquer::estimate
