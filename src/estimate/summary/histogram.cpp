// Summaries "histogram": means of each sixteenth of the sorted values, of luminance and of two bands of it.
#include <algorithm>
#include <array>

#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

constexpr size_t kBins = 16;

/// Which sixteenth of the sorted values each one belongs to. Equal values are sorted by their place.
class Sixteenths {
  public:
    void Sort(std::span<const double> values) {
        order_.resize(values.size());
        bins_.resize(values.size());
        for (size_t i = 0; i < order_.size(); ++i) order_[i] = int(i);
        Split(values, 0, kBins);
        for (size_t bin = 0; bin < kBins; ++bin)
            for (size_t i = First(bin); i < First(bin + 1); ++i) bins_[size_t(order_[i])] = int(bin);
    }
    size_t BinOf(size_t i) const { return size_t(bins_[i]); }
    double Count(size_t bin) const { return double(First(bin + 1) - First(bin)); }

  private:
    size_t First(size_t bin) const { return bin * order_.size() / kBins; }
    void Split(std::span<const double> values, size_t from, size_t to) {
        if (to - from < 2) return;
        const size_t middle = (from + to) / 2;
        const auto at = [this](size_t bin) { return order_.begin() + std::ptrdiff_t(First(bin)); };
        std::nth_element(at(from), at(middle), at(to), [&](int a, int b) {
            const double va = values[size_t(a)], vb = values[size_t(b)];
            return va < vb || (va == vb && a < b);
        });
        Split(values, from, middle);
        Split(values, middle, to);
    }
    std::vector<int> order_, bins_;
};

class HistogramSummary final : public Summary {
  public:
    explicit HistogramSummary(const MapGrid& grid) : size_(grid.size) {
        for (const char* what : {"luminance", "fine detail", "coarser detail"})
            for (size_t bin = 0; bin < kBins; ++bin) names_.push_back(fmt::format("{} {}/16", what, bin + 1));
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        BinomialBlur(size_, 1, input.luminance, &bands_[1]);
        BinomialBlur(size_, 2, bands_[1], &bands_[2]);
        bands_[0] = input.luminance;
        for (size_t i = 0; i < bands_[0].size(); ++i) {
            const double once = bands_[1][i], twice = bands_[2][i];
            bands_[1][i] = bands_[0][i] - once;
            bands_[2][i] = once - twice;
        }
        std::fill(values.begin(), values.end(), 0.);
        for (size_t band = 0; band < 3; ++band) {
            sixteenths_[band].Sort(bands_[band]);
            const auto out = values.subspan(band * kBins, kBins);
            for (size_t i = 0; i < bands_[band].size(); ++i)
                out[sixteenths_[band].BinOf(i)] += bands_[band][i];
            for (size_t bin = 0; bin < kBins; ++bin) out[bin] /= sixteenths_[band].Count(bin);
        }
    }

    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        std::array<std::vector<double>, 3> byBand;
        for (size_t band = 0; band < 3; ++band) {
            byBand[band].resize(bands_[band].size());
            for (size_t i = 0; i < byBand[band].size(); ++i) {
                const size_t bin = sixteenths_[band].BinOf(i);
                byBand[band][i] = by[band * kBins + bin] / sixteenths_[band].Count(bin);
            }
        }
        // once = blur(luminance), twice = blur(once): fine = luminance - once, coarser = once - twice.
        std::vector<double> spread, byOnce(byBand[0].size());
        BinomialBlurAdjoint(size_, 2, byBand[2], &spread);
        for (size_t i = 0; i < byOnce.size(); ++i) byOnce[i] = byBand[2][i] - spread[i] - byBand[1][i];
        BinomialBlurAdjoint(size_, 1, byOnce, &spread);
        for (size_t i = 0; i < byOnce.size(); ++i)
            byInput->luminance[i] += byBand[0][i] + byBand[1][i] + spread[i];
    }

  private:
    int size_;
    std::array<std::vector<double>, 3> bands_;  ///< luminance, fine detail, coarser detail
    std::array<Sixteenths, 3> sixteenths_;
};

}  // namespace

std::unique_ptr<Summary> MakeHistogramSummary(const MapGrid& grid) {
    return std::make_unique<HistogramSummary>(grid);
}

}  // namespace lacquer::estimate
