// Summaries "gram": how often random filters answer together.
#include <array>
#include <cmath>

#include "estimate/random.h"
#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

constexpr size_t kChannels = 10;
constexpr uint64_t kFilterSeed = 20;  ///< the filters are the same for all images
constexpr double kFloor = 1e-9;

/// Filters of one size, with zero mean over all taps and colours, and unit length; every `stride`-th answer,
/// less than 0 cut off.
class FilterLayer {
  public:
    FilterLayer(int size, int taps)
        : size_(size), taps_(taps), stride_(std::max(1, taps / 4)), outSize_((size - taps) / stride_ + 1) {
        Random random(kFilterSeed, taps);
        for (auto& filter : filters_) {
            filter.resize(3 * size_t(taps * taps));
            double mean = 0, squares = 0;
            for (double& w : filter) mean += (w = random.Normal()) / double(filter.size());
            for (double& w : filter) squares += (w - mean) * (w - mean);
            for (double& w : filter) w = (w - mean) / std::sqrt(squares);
        }
        for (auto& answer : answers_) answer.resize(size_t(outSize_) * size_t(outSize_));
    }

    static constexpr size_t kSize = kChannels * (kChannels + 1) / 2;

    void Forward(const PlanarImage& image, std::span<double> values) {
        for (size_t c = 0; c < kChannels; ++c) {
            for (int row = 0; row < outSize_; ++row) Convolve(image, c, row);
            for (double& v : answers_[c]) v = std::max(v, 0.);
        }
        size_t next = 0;
        for (size_t a = 0; a < kChannels; ++a)
            for (size_t b = a; b < kChannels; ++b) {
                double sum = 0;
                for (size_t i = 0; i < answers_[a].size(); ++i) sum += answers_[a][i] * answers_[b][i];
                values[next] = roots_[next] = std::sqrt(sum / double(answers_[a].size()) + kFloor);
                ++next;
            }
    }

    void Backward(std::span<const double> by, PlanarImage* byImage) const {
        std::vector<double> byAnswer(answers_[0].size());
        for (size_t c = 0; c < kChannels; ++c) {
            std::fill(byAnswer.begin(), byAnswer.end(), 0.);
            size_t next = 0;
            for (size_t a = 0; a < kChannels; ++a)
                for (size_t b = a; b < kChannels; ++b, ++next) {
                    if (a != c && b != c) continue;
                    const auto& other = answers_[a == c ? b : a];
                    // A channel with itself counts twice.
                    const double scale =
                        by[next] * (a == b ? 1 : 0.5) / (roots_[next] * double(other.size()));
                    for (size_t i = 0; i < other.size(); ++i) byAnswer[i] += scale * other[i];
                }
            for (size_t i = 0; i < byAnswer.size(); ++i) byAnswer[i] *= answers_[c][i] > 0;
            for (int row = 0; row < outSize_; ++row) Scatter(byAnswer, c, row, byImage);
        }
    }

  private:
    const double* Weights(size_t channel, size_t color, int tapRow) const {
        return &filters_[channel][(color * size_t(taps_) + size_t(tapRow)) * size_t(taps_)];
    }
    size_t FirstPixel(size_t color, int imageRow) const {
        return (color * size_t(size_) + size_t(imageRow)) * size_t(size_);
    }

    void Convolve(const PlanarImage& image, size_t channel, int row) {
        double* out = &answers_[channel][size_t(row) * size_t(outSize_)];
        std::fill(out, out + outSize_, 0.);
        for (size_t color = 0; color < 3; ++color)
            for (int i = 0; i < taps_; ++i) {
                const double* in = &image.values[FirstPixel(color, row * stride_ + i)];
                const double* w = Weights(channel, color, i);
                for (int j = 0; j < taps_; ++j)
                    for (int x = 0; x < outSize_; ++x) out[x] += w[j] * in[x * stride_ + j];
            }
    }
    void Scatter(const std::vector<double>& by, size_t channel, int row, PlanarImage* image) const {
        const double* from = &by[size_t(row) * size_t(outSize_)];
        for (size_t color = 0; color < 3; ++color)
            for (int i = 0; i < taps_; ++i) {
                double* out = &image->values[FirstPixel(color, row * stride_ + i)];
                const double* w = Weights(channel, color, i);
                for (int j = 0; j < taps_; ++j)
                    for (int x = 0; x < outSize_; ++x) out[x * stride_ + j] += w[j] * from[x];
            }
    }

    int size_, taps_, stride_, outSize_;
    std::array<std::vector<double>, kChannels> filters_, answers_;
    std::array<double, kSize> roots_{};
};

class GramSummary final : public Summary {
  public:
    explicit GramSummary(const MapGrid& grid) {
        for (const int taps : {3, 5, 9, 15}) {
            layers_.emplace_back(grid.size, taps);
            for (size_t a = 0; a < kChannels; ++a)
                for (size_t b = a; b < kChannels; ++b)
                    names_.push_back(
                        fmt::format("random filters {} and {} of {} pixels", a + 1, b + 1, taps));
        }
    }
    void Forward(const SummaryInput& input, std::span<double> values) override {
        for (size_t k = 0; k < layers_.size(); ++k)
            layers_[k].Forward(input.image, values.subspan(k * FilterLayer::kSize, FilterLayer::kSize));
    }
    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        for (size_t k = 0; k < layers_.size(); ++k)
            layers_[k].Backward(by.subspan(k * FilterLayer::kSize, FilterLayer::kSize), &byInput->image);
    }

  private:
    std::vector<FilterLayer> layers_;
};

}  // namespace

std::unique_ptr<Summary> MakeGramSummary(const MapGrid& grid) { return std::make_unique<GramSummary>(grid); }

}  // namespace lacquer::estimate
