// Summaries "colour", and the regions of "rings" and "columns".
#include <algorithm>
#include <cmath>

#include "estimate/summary/summary.h"

namespace lacquer::estimate {
namespace {

/// Distance of a pixel from the middle, in half sides.
double RadiusAt(int size, int row, int column) {
    const double x = (column + 0.5) / size * 2 - 1, y = (row + 0.5) / size * 2 - 1;
    return std::hypot(x, y);
}

class ColorSummary final : public Summary {
  public:
    explicit ColorSummary(const MapGrid& grid) : weights_(grid.NumPoints()) {
        const char* channels[] = {"red", "green", "blue"};
        for (const char* c : channels) names_.push_back(fmt::format("mean of {}", c));
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                names_.push_back(i == j ? fmt::format("variance of {}", channels[i])
                                        : fmt::format("covariance of {} and {}", channels[i], channels[j]));
        for (const char* c : channels) names_.push_back(fmt::format("{} of the centre over the rim", c));
        // The centre has half of the side as its diameter; the rim is what lies beyond 0.8 of the half side.
        size_t centre = 0, rim = 0;
        for (int row = 0; row < grid.size; ++row)
            for (int column = 0; column < grid.size; ++column) {
                const double r = RadiusAt(grid.size, row, column);
                weights_[size_t(row) * size_t(grid.size) + size_t(column)] = r < 0.5 ? 1 : r > 0.8 ? -1 : 0;
                centre += r < 0.5;
                rim += r > 0.8;
            }
        for (double& w : weights_) w /= w > 0 ? double(centre) : double(rim);
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        const double count = double(weights_.size());
        for (size_t k = 0; k < 3; ++k) {
            double sum = 0, contrast = 0;
            const auto channel = input.image.Channel(k);
            for (size_t i = 0; i < channel.size(); ++i) {
                sum += channel[i];
                contrast += weights_[i] * channel[i];
            }
            values[k] = means_[k] = sum / count;
            values[9 + k] = contrast;
        }
        size_t next = 3;
        for (size_t k = 0; k < 3; ++k)
            for (size_t l = k; l < 3; ++l) {
                const auto a = input.image.Channel(k), b = input.image.Channel(l);
                double sum = 0;
                for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - means_[k]) * (b[i] - means_[l]);
                values[next++] = sum / count;
            }
    }

    void Backward(const SummaryInput& input, std::span<const double> by, SummaryInput* byInput) override {
        const double count = double(weights_.size());
        // The derivative of a covariance by a mean is 0.
        const double matrix[3][3] = {
            {2 * by[3], by[4], by[5]}, {by[4], 2 * by[6], by[7]}, {by[5], by[7], 2 * by[8]}};
        const auto r = input.image.Channel(0), g = input.image.Channel(1), b = input.image.Channel(2);
        for (size_t k = 0; k < 3; ++k) {
            const auto out = byInput->image.Channel(k);
            for (size_t i = 0; i < out.size(); ++i)
                out[i] += (by[k] + matrix[k][0] * (r[i] - means_[0]) + matrix[k][1] * (g[i] - means_[1]) +
                           matrix[k][2] * (b[i] - means_[2])) /
                              count +
                          by[9 + k] * weights_[i];
        }
    }

  private:
    std::vector<double> weights_;  ///< of the contrast of centre and rim
    std::array<double, 3> means_{};
};

/// Mean, and half the log of the energy of fine detail, in regions.
class RegionSummary final : public Summary {
  public:
    /// @param regions  of each pixel, -1 for none
    RegionSummary(int size, int count, std::vector<int> regions, std::string_view what)
        : size_(size), regions_(std::move(regions)), weights_(size_t(count)), energies_(size_t(count)) {
        for (const int r : regions_)
            if (r >= 0) weights_[size_t(r)] += 1;
        for (double& w : weights_) w = 1 / w;
        for (int i = 0; i < count; ++i) names_.push_back(fmt::format("mean of {} {}", what, i + 1));
        for (int i = 0; i < count; ++i) names_.push_back(fmt::format("fine detail of {} {}", what, i + 1));
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        const size_t count = weights_.size();
        BinomialBlur(size_, 1, input.luminance, &detail_);
        std::fill(values.begin(), values.end(), 0.);
        for (size_t i = 0; i < detail_.size(); ++i) {
            detail_[i] = input.luminance[i] - detail_[i];
            if (regions_[i] < 0) continue;
            const size_t region = size_t(regions_[i]);
            values[region] += input.luminance[i];
            values[count + region] += detail_[i] * detail_[i];
        }
        for (size_t r = 0; r < count; ++r) {
            values[r] *= weights_[r];
            energies_[r] = values[count + r] * weights_[r] + kFloor;
            values[count + r] = 0.5 * std::log(energies_[r]);
        }
    }

    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        const size_t count = weights_.size();
        std::vector<double> byDetail(detail_.size(), 0.), byBlur;
        for (size_t i = 0; i < detail_.size(); ++i) {
            if (regions_[i] < 0) continue;
            const size_t region = size_t(regions_[i]);
            byInput->luminance[i] += by[region] * weights_[region];
            byDetail[i] = by[count + region] * weights_[region] * detail_[i] / energies_[region];
        }
        BinomialBlurAdjoint(size_, 1, byDetail, &byBlur);
        for (size_t i = 0; i < detail_.size(); ++i) byInput->luminance[i] += byDetail[i] - byBlur[i];
    }

  private:
    static constexpr double kFloor = kRoundingVariance;  ///< energy of a region without any detail
    int size_;
    std::vector<int> regions_;
    std::vector<double> weights_, energies_, detail_;
};

}  // namespace

std::unique_ptr<Summary> MakeColorSummary(const MapGrid& grid) {
    return std::make_unique<ColorSummary>(grid);
}

std::unique_ptr<Summary> MakeRingSummary(const MapGrid& grid) {
    constexpr int kRings = 12;
    std::vector<int> regions;
    for (int row = 0; row < grid.size; ++row)
        for (int column = 0; column < grid.size; ++column) {
            const int ring = int(RadiusAt(grid.size, row, column) * kRings);
            regions.push_back(ring < kRings ? ring : -1);
        }
    return std::make_unique<RegionSummary>(grid.size, kRings, std::move(regions), "ring");
}

std::unique_ptr<Summary> MakeColumnSummary(const MapGrid& grid) {
    const int count = grid.size >= 256 ? 64 : 32;
    std::vector<int> regions;
    for (int row = 0; row < grid.size; ++row)
        for (int column = 0; column < grid.size; ++column) regions.push_back(column * count / grid.size);
    return std::make_unique<RegionSummary>(grid.size, count, std::move(regions), "column");
}

}  // namespace lacquer::estimate
