// Summaries "gram": how often random filters answer together.
#include <array>
#include <cmath>

#include "estimate/random.h"
#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

constexpr size_t kChannels = 10;
/// Filters are the same for all images.
constexpr uint64_t kFilterSeed = 20;
constexpr double kFloor = kRoundingVariance;

/// Answers of all filters at one place: eight in each of two vectors, the last six always 0.
struct Answers {
    static constexpr size_t kLanes = 8;
    typedef double Vector __attribute__((vector_size(sizeof(double) * kLanes)));
    Vector low{}, high{};

    double operator[](size_t channel) const {
        return channel < kLanes ? low[channel] : high[channel - kLanes];
    }
    void Set(size_t channel, double value) {
        if (channel < kLanes)
            low[channel] = value;
        else
            high[channel - kLanes] = value;
    }
    void AddScaled(double scale, const Answers& other) {
        low += scale * other.low;
        high += scale * other.high;
    }
};

/// Filters of one size, with zero mean over all taps and colours, and unit length; every `stride`-th answer,
/// less than 0 cut off.
class FilterLayer {
  public:
    FilterLayer(int size, int taps)
        : size_(size),
          taps_(taps),
          stride_(std::max(1, taps / 4)),
          outSize_((size - taps) / stride_ + 1),
          filters_(3 * size_t(taps * taps)),
          answers_(size_t(outSize_) * size_t(outSize_)) {
        Random random(kFilterSeed, taps);
        for (size_t c = 0; c < kChannels; ++c) {
            std::vector<double> weights(filters_.size());
            double mean = 0, squares = 0;
            for (double& w : weights) mean += (w = random.Normal()) / double(weights.size());
            for (const double w : weights) squares += (w - mean) * (w - mean);
            for (size_t i = 0; i < weights.size(); ++i)
                filters_[i].Set(c, (weights[i] - mean) / std::sqrt(squares));
        }
    }

    static constexpr size_t kSize = kChannels * (kChannels + 1) / 2;

    void Forward(const PlanarImage& image, std::span<double> values) {
        std::array<Answers, kChannels> sums{};
        for (int row = 0; row < outSize_; ++row) {
            Convolve(image, row);
            for (int x = 0; x < outSize_; ++x) {
                const Answers& a = answers_[Place(row, x)];
                for (size_t c = 0; c < kChannels; ++c) sums[c].AddScaled(a[c], a);
            }
        }
        size_t next = 0;
        for (size_t a = 0; a < kChannels; ++a)
            for (size_t b = a; b < kChannels; ++b, ++next)
                values[next] = roots_[next] = std::sqrt(sums[a][b] / double(answers_.size()) + kFloor);
    }

    void Backward(std::span<const double> by, PlanarImage* byImage) const {
        // Row c: derivatives by answer c, for each of the answers beside it. A channel with itself counts
        // twice.
        std::array<Answers, kChannels> matrix{};
        size_t next = 0;
        for (size_t a = 0; a < kChannels; ++a)
            for (size_t b = a; b < kChannels; ++b, ++next) {
                const double scale = by[next] * (a == b ? 1 : 0.5) / (roots_[next] * double(answers_.size()));
                matrix[a].Set(b, scale);
                matrix[b].Set(a, scale);
            }
        for (int row = 0; row < outSize_; ++row)
            for (int x = 0; x < outSize_; ++x) {
                const Answers& answer = answers_[Place(row, x)];
                Answers byAnswer;
                for (size_t c = 0; c < kChannels; ++c) byAnswer.AddScaled(answer[c], matrix[c]);
                for (size_t c = 0; c < kChannels; ++c)
                    if (answer[c] <= 0) byAnswer.Set(c, 0);
                Scatter(byAnswer, row, x, byImage);
            }
    }

  private:
    size_t Place(int row, int x) const { return size_t(row) * size_t(outSize_) + size_t(x); }
    size_t FirstPixel(size_t color, int imageRow) const {
        return (color * size_t(size_) + size_t(imageRow)) * size_t(size_);
    }
    const Answers* FilterRow(size_t color, int row) const {
        return &filters_[(color * size_t(taps_) + size_t(row)) * size_t(taps_)];
    }

    /// A row of answers, four at a time: each tap is read once for them.
    void Convolve(const PlanarImage& image, int row) {
        constexpr int kAtOnce = 4;
        for (int first = 0; first < outSize_; first += kAtOnce) {
            // The last ones are made again rather than made alone.
            const int x0 = std::min(first, outSize_ - kAtOnce);
            Answers sums[kAtOnce];
            for (size_t color = 0; color < 3; ++color)
                for (int i = 0; i < taps_; ++i) {
                    const double* in = &image.values[FirstPixel(color, row * stride_ + i)] + x0 * stride_;
                    const Answers* w = FilterRow(color, i);
                    for (int j = 0; j < taps_; ++j)
                        for (int k = 0; k < kAtOnce; ++k) sums[k].AddScaled(in[k * stride_ + j], w[j]);
                }
            for (int k = 0; k < kAtOnce; ++k) {
                Answers& out = answers_[Place(row, x0 + k)];
                out.low = sums[k].low > 0 ? sums[k].low : Answers::Vector{};
                out.high = sums[k].high > 0 ? sums[k].high : Answers::Vector{};
            }
        }
    }
    void Scatter(const Answers& by, int row, int x, PlanarImage* image) const {
        for (size_t color = 0; color < 3; ++color)
            for (int i = 0; i < taps_; ++i) {
                double* out = &image->values[FirstPixel(color, row * stride_ + i)] + x * stride_;
                const Answers* w = FilterRow(color, i);
                for (int j = 0; j < taps_; ++j) {
                    const Answers::Vector products = by.low * w[j].low + by.high * w[j].high;
                    out[j] += ((products[0] + products[4]) + (products[1] + products[5])) +
                              ((products[2] + products[6]) + (products[3] + products[7]));
                }
            }
    }

    int size_, taps_, stride_, outSize_;
    std::vector<Answers> filters_, answers_;  ///< filters: by colour, row, column of taps
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
