#include "pbrt/samplers/block_sampler.h"

#include "pbrt/samplers/low_discrepancy.h"

namespace lacquer {

namespace {

/// The dimensions of a point, as reversed fractions.
using Fractions = uint32_t __attribute__((vector_size(4 * LeadingNumbers::kBlock)));

/// Sobol matrices times all values of each four bits of the index.
class PointTables {
  public:
    PointTables() {
        const std::vector<SobolColumns> matrices = MakeSobolMatrices(int(LeadingNumbers::kBlock));
        for (size_t place = 0; place < rows_.size(); ++place)
            for (size_t value = 0; value < rows_[place].size(); ++value)
                for (size_t d = 0; d < matrices.size(); ++d)
                    for (size_t bit = 0; bit < 4; ++bit)
                        if ((value >> bit) & 1) rows_[place][value][d] ^= matrices[d][4 * place + bit];
    }
    Fractions ValuesOf(uint32_t index) const {
        Fractions v{};
        for (size_t place = 0; place < rows_.size(); ++place) v ^= rows_[place][(index >> (4 * place)) & 15];
        return v;
    }

  private:
    std::array<std::array<Fractions, 16>, 8> rows_{};  ///< [place of the four][their value]
};

/// The finaliser of MurmurHash3, so that the seeds of the dimensions have nothing in common.
Fractions MixFractions(Fractions v) {
    v ^= v >> 16;
    v *= 0x85ebca6bu;
    v ^= v >> 13;
    v *= 0xc2b2ae35u;
    return v ^ (v >> 16);
}

// FastOwenReversed() and ReverseBits() with a seed of its own for each dimension; GCC does not find these
// vector instructions by itself.
Fractions FastOwenFractions(Fractions v, Fractions seeds) {
    v ^= v * 0x3d20adeau;
    v += seeds;
    v *= (seeds >> 16) | 1;
    v ^= v * 0x05526c56u;
    return v ^ (v * 0x53a22864u);
}
Fractions ReverseFractions(Fractions v) {
    v = (v << 16) | (v >> 16);
    v = ((v & 0x00ff00ffu) << 8) | ((v & 0xff00ff00u) >> 8);
    v = ((v & 0x0f0f0f0fu) << 4) | ((v & 0xf0f0f0f0u) >> 4);
    v = ((v & 0x33333333u) << 2) | ((v & 0xccccccccu) >> 2);
    return ((v & 0x55555555u) << 1) | ((v & 0xaaaaaaaau) >> 1);
}

}  // namespace

void BlockSampler::StartBlock(Int2 pixel, int first) {
    const bool isNewPixel = pixel != pixel_ || firstIndex_ < 0;
    pixel_ = pixel;
    firstIndex_ = first;
    blockTag_ += 2;
    if (!isNewPixel) return;
    ++pixelTag_;
    constexpr uint64_t kPoints = 0x706f696e74730000;  // apart from the sampler's own dimensions
    pointsHash_ = Hash(pixel.x, pixel.y, seed_, kPoints);
    StartPixel();
}

void BlockSampler::Refill1D(int dimension, Entry& entry) {
    Fill1D(dimension, entry.x);
    entry.tag = blockTag_;
}

void BlockSampler::Refill2D(int dimension, Entry& entry) {
    Fill2D(dimension, entry.x, entry.y);
    entry.tag = blockTag_ + 1;
}

bool BlockSampler::GetPoint(const PointSet& set, LeadingNumbers::Block* x) const {
    static const PointTables tables;
    const uint64_t hash = MixBits(pointsHash_ ^ set.key);
    // A nested shuffle: the first 2^k samples become an aligned block of the sequence for every k.
    const uint32_t index = uint32_t(firstIndex_ + int(lane_)) * set.copies + set.copy;
    const Fractions v = tables.ValuesOf(ReverseBits(FastOwenReversed(ReverseBits(index), uint32_t(hash))));
    const Fractions dimensions{0, 1, 2, 3, 4, 5, 6, 7};
    const Fractions seeds = MixFractions(uint32_t(hash >> 32) + dimensions * 0x9e3779b9u);
    const Fractions fractions = ReverseFractions(FastOwenFractions(v, seeds));
    for (size_t d = 0; d < x->size(); ++d) (*x)[d] = UnitFloat32(fractions[d]);
    return true;
}

Point2 BlockSampler::Independent(int dimension) const {
    return Rng(Hash(pixel_.x, pixel_.y, firstIndex_ + int(lane_), seed_, dimension)).Uniform2D();
}

}  // namespace lacquer
