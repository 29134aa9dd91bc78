#include "estimate/summary/vgg.h"

#include <fmt/format.h>

#include "estimate/random.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {
namespace {

constexpr int kBlocks = 5, kProjections = 40;
constexpr uint64_t kProjectionSeed = 19;
constexpr size_t kNumLayers = 16;

/// Channels of an image side by side: a column for each pixel, rows of pixels.
struct Features {
    int size = 0;
    Eigen::MatrixXd values;
};

/// Rows of an image whose surroundings of 3 x 3 pixels are written out at once.
int RowsAtOnce(int size) { return std::max(1, 2048 / size); }

/// Calls visit(pixel, part, neighbour) for the nine parts of the surroundings of each pixel of some rows;
/// neighbour is -1 beyond the border.
template <class Visit>
void VisitSurroundings(int size, int firstRow, int numRows, const Visit& visit) {
    for (int row = 0; row < numRows; ++row)
        for (int column = 0; column < size; ++column)
            for (int part = 0; part < 9; ++part) {
                const int y = firstRow + row + part / 3 - 1, x = column + part % 3 - 1;
                const bool isInside = y >= 0 && y < size && x >= 0 && x < size;
                visit(row * size + column, part, isInside ? y * size + x : -1);
            }
}

/// Convolution, and what is below 0 cut off. Beyond the border are zeros.
void Convolve(const VggWeights::Layer& layer, const Features& in, Features* out) {
    const Eigen::Index channels = in.values.rows();
    out->size = in.size;
    out->values.resize(layer.weights.rows(), in.values.cols());
    Eigen::MatrixXd surroundings;
    for (int row = 0; row < in.size; row += RowsAtOnce(in.size)) {
        const int rows = std::min(RowsAtOnce(in.size), in.size - row);
        surroundings.setZero(9 * channels, rows * in.size);
        VisitSurroundings(in.size, row, rows, [&](int pixel, int part, int neighbour) {
            if (neighbour >= 0)
                surroundings.col(pixel).segment(part * channels, channels) = in.values.col(neighbour);
        });
        auto target = out->values.middleCols(row * in.size, rows * in.size);
        target.noalias() = layer.weights * surroundings;
        target = (target.colwise() + layer.bias).cwiseMax(0.);
    }
}
/// @param byOut  of the output, which is positive where it counts; is changed
void ConvolveAdjoint(const VggWeights::Layer& layer, const Features& out, Features* byOut, Features* byIn) {
    const Eigen::Index channels = layer.weights.cols() / 9;
    byOut->values = (out.values.array() > 0).select(byOut->values, 0.);
    byIn->size = out.size;
    byIn->values.setZero(channels, out.values.cols());
    Eigen::MatrixXd surroundings;
    for (int row = 0; row < out.size; row += RowsAtOnce(out.size)) {
        const int rows = std::min(RowsAtOnce(out.size), out.size - row);
        surroundings.noalias() =
            layer.weights.transpose() * byOut->values.middleCols(row * out.size, rows * out.size);
        VisitSurroundings(out.size, row, rows, [&](int pixel, int part, int neighbour) {
            if (neighbour >= 0)
                byIn->values.col(neighbour) += surroundings.col(pixel).segment(part * channels, channels);
        });
    }
}

void Halve(const Features& in, Features* out) {
    out->size = in.size / 2;
    out->values.resize(in.values.rows(), out->size * out->size);
    for (int i = 0; i < out->size; ++i)
        for (int j = 0; j < out->size; ++j) {
            const int first = 2 * i * in.size + 2 * j;
            out->values.col(i * out->size + j) =
                0.25 * (in.values.col(first) + in.values.col(first + 1) + in.values.col(first + in.size) +
                        in.values.col(first + in.size + 1));
        }
}
/// Adds to `byIn`.
void HalveAdjoint(const Features& byOut, Features* byIn) {
    for (int i = 0; i < byOut.size; ++i)
        for (int j = 0; j < byOut.size; ++j)
            for (const int offset : {0, 1, byIn->size, byIn->size + 1})
                byIn->values.col(2 * i * byIn->size + 2 * j + offset) +=
                    0.25 * byOut.values.col(i * byOut.size + j);
}

class VggSummary final : public Summary {
  public:
    VggSummary(const MapGrid& grid, std::shared_ptr<const VggWeights> weights)
        : size_(grid.size), weights_(std::move(weights)), outputs_(weights_->layers.size()) {
        size_t last = 0;
        for (int block = 0; block < kBlocks; ++block) {
            last += size_t(kVggLayersOfBlock[size_t(block)]);
            const Eigen::Index channels = weights_->layers[last - 1].weights.rows();
            Random random(kProjectionSeed, block);
            for (Eigen::MatrixXd* m : {&left_[size_t(block)], &right_[size_t(block)]}) {
                m->resize(kProjections, channels);
                for (Eigen::Index i = 0; i < m->size(); ++i)
                    m->data()[i] = random.Normal() / std::sqrt(double(channels));
            }
            for (int k = 0; k < kProjections; ++k)
                names_.push_back(fmt::format("projection {} of the network's block {}", k + 1, block + 1));
        }
    }

    void Forward(const SummaryInput& input, std::span<double> values) override {
        Features image{size_, Eigen::MatrixXd(3, Eigen::Index(input.image.NumPixels()))};
        for (size_t k = 0; k < 3; ++k)
            for (size_t i = 0; i < input.image.NumPixels(); ++i)
                image.values(Eigen::Index(k), Eigen::Index(i)) =
                    (input.image.Channel(k)[i] - kVggMeans[k]) / kVggDeviations[k];
        size_t layer = 0;
        for (size_t block = 0; block < kBlocks; ++block) {
            for (int i = 0; i < kVggLayersOfBlock[block]; ++i, ++layer)
                Convolve(weights_->layers[layer], i == 0 ? image : outputs_[layer - 1], &outputs_[layer]);
            const Features& tap = outputs_[layer - 1];
            const Eigen::VectorXd means =
                (left_[block] * tap.values).cwiseProduct(right_[block] * tap.values).rowwise().mean();
            for (int k = 0; k < kProjections; ++k) values[block * kProjections + size_t(k)] = means[k];
            if (block + 1 < kBlocks) Halve(tap, &image);
        }
    }

    void Backward(const SummaryInput&, std::span<const double> by, SummaryInput* byInput) override {
        Features current, next;
        size_t layer = outputs_.size();
        for (size_t block = kBlocks; block-- > 0;) {
            const Features& tap = outputs_[layer - 1];
            Features byTap{tap.size, TapAdjoint(block, by.subspan(block * kProjections, kProjections), tap)};
            if (block + 1 < kBlocks) HalveAdjoint(current, &byTap);
            current = std::move(byTap);
            for (int i = 0; i < kVggLayersOfBlock[block]; ++i) {
                --layer;
                ConvolveAdjoint(weights_->layers[layer], outputs_[layer], &current, &next);
                std::swap(current, next);
            }
        }
        for (size_t k = 0; k < 3; ++k) {
            const auto out = byInput->image.Channel(k);
            for (size_t i = 0; i < out.size(); ++i)
                out[i] += current.values(Eigen::Index(k), Eigen::Index(i)) / kVggDeviations[k];
        }
    }

  private:
    Eigen::MatrixXd TapAdjoint(size_t block, std::span<const double> by, const Features& tap) const {
        const Eigen::VectorXd scale =
            Eigen::Map<const Eigen::VectorXd>(by.data(), kProjections) / double(tap.values.cols());
        const Eigen::MatrixXd byLeft = scale.asDiagonal() * (right_[block] * tap.values);
        const Eigen::MatrixXd byRight = scale.asDiagonal() * (left_[block] * tap.values);
        return left_[block].transpose() * byLeft + right_[block].transpose() * byRight;
    }

    int size_;
    std::shared_ptr<const VggWeights> weights_;
    std::vector<Features> outputs_;  ///< of all layers
    std::array<Eigen::MatrixXd, kBlocks> left_, right_;
};

}  // namespace

std::shared_ptr<const VggWeights> VggWeights::Read(const std::string& path,
                                                   const std::array<size_t, 5>& channels) {
    auto weights = std::make_shared<VggWeights>();
    for (const VggLayer& read : ReadVggLayers(path, kNumLayers, channels)) {
        Layer layer{Eigen::MatrixXd(Eigen::Index(read.out), Eigen::Index(9 * read.in)),
                    Eigen::VectorXd(Eigen::Index(read.out))};
        for (size_t o = 0; o < read.out; ++o) {
            layer.bias[Eigen::Index(o)] = double(read.bias[o]);
            for (size_t c = 0; c < read.in; ++c)
                for (size_t part = 0; part < 9; ++part)
                    layer.weights(Eigen::Index(o), Eigen::Index(part * read.in + c)) =
                        double(read.weights[(o * read.in + c) * 9 + part]);
        }
        weights->layers.push_back(std::move(layer));
    }
    return weights;
}

std::unique_ptr<Summary> MakeVggSummary(const MapGrid& grid, std::shared_ptr<const VggWeights> weights) {
    LACQUER_CHECK(weights && weights->layers.size() == kNumLayers);
    return std::make_unique<VggSummary>(grid, std::move(weights));
}

}  // namespace lacquer::estimate
