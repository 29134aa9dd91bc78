#include "samplers/net_gains.h"

#include <bit>
#include <cmath>
#include <vector>

namespace lacquer::test {

namespace {

/// Vectors over GF(2) of which none is a sum of others, each by its highest bit.
class Basis {
  public:
    void Add(uint32_t v) {
        while (v) {
            uint32_t& known = vectors_[size_t(std::bit_width(v)) - 1];
            if (!known) {
                known = v;
                ++rank_;
                return;
            }
            v ^= known;
        }
    }
    int Rank() const { return rank_; }

  private:
    std::array<uint32_t, 32> vectors_{};
    int rank_ = 0;
};

/// How many of 2^m points are in one box with any of them, by the levels of its sides.
class PointsInBoxes {
  public:
    PointsInBoxes(std::span<const BitMatrix* const> dimensions, int m, int levels)
        : dimensions_(dimensions), m_(m), levels_(levels) {
        Count(0, Basis());
    }
    double Of(std::span<const int> levels) const {
        size_t index = 0;
        for (const int level : levels) index = index * size_t(levels_ + 1) + size_t(level);
        return counts_[index];
    }

  private:
    void Count(size_t dimension, Basis basis) {
        if (dimension == dimensions_.size()) {
            counts_.push_back(std::ldexp(1., m_ - basis.Rank()));
            return;
        }
        const uint32_t mask = (uint32_t(1) << m_) - 1;
        for (int level = 0; level <= levels_; ++level) {
            if (level > 0) basis.Add((*dimensions_[dimension])[size_t(level) - 1] & mask);
            Count(dimension + 1, basis);
        }
    }

    std::span<const BitMatrix* const> dimensions_;
    int m_, levels_;
    std::vector<double> counts_;
};

/// Of one interaction: the sum over points of the product of 2 [same box at this level] - [same at the one
/// above].
double Gain(const PointsInBoxes& points, std::span<const int> levels) {
    double gain = 0;
    std::vector<int> box(levels.size());
    for (unsigned fine = 0; fine < 1u << levels.size(); ++fine) {
        for (size_t d = 0; d < levels.size(); ++d) box[d] = levels[d] - (fine >> d & 1 ? 0 : 1);
        const int numFine = std::popcount(fine), numCoarse = int(levels.size()) - numFine;
        gain += std::ldexp(numCoarse % 2 ? -1. : 1., numFine) * points.Of(box);
    }
    return gain;
}

}  // namespace

BitMatrix SobolSecondAfter(const BitMatrix& order) {
    BitMatrix result{};
    for (unsigned row = 0; row < result.size(); ++row)
        for (unsigned k = row; k < order.size(); ++k)
            if ((row & k) == row) result[row] ^= order[k];  // binomial(k, row) is odd
    return result;
}

double MeanGain(std::span<const BitMatrix* const> dimensions, int m, int levels) {
    const PointsInBoxes points(dimensions, m, levels);
    double sum = 0, sumOfWeights = 0;
    std::vector<int> level(dimensions.size(), 1);
    for (bool isDone = false; !isDone;) {
        int total = 0;
        for (const int l : level) total += l;
        const double weight = std::pow(2.8, -total);
        sum += weight * Gain(points, level);
        sumOfWeights += weight;
        isDone = true;
        for (size_t d = 0; d < level.size() && isDone; ++d) {
            isDone = level[d] == levels;
            level[d] = isDone ? 1 : level[d] + 1;
        }
    }
    return sum / sumOfWeights;
}

double MeanGainAcross(const PairOfDimensions& a, const PairOfDimensions& b, int m) {
    double sum = 0;
    for (const BitMatrix* i : {&a.x, &a.y})
        for (const BitMatrix* k : {&b.x, &b.y}) sum += MeanGain(std::array{i, k}, m, 5);
    return sum / 4;
}

}  // namespace lacquer::test
