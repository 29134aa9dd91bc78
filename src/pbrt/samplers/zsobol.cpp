// Sampler "zsobol": Sobol points assigned to the pixels along a Morton curve whose quadrants are permuted at
// random: neighbours get complementary points, so the error looks like blue noise [Ahmed and Wonka 2020]. Not
// as there, those dimensions that most paths use share the permutations, and are well distributed together.
//
//   "integer pixelsamples"  16            samples per pixel, rounded down to a power of two
//   "string randomization"  fastowen      or "permutedigits", "none", "owen"
//   "integer seed"          the option's  of the random numbers
#include <fmt/format.h>

#include "pbrt/core/progress.h"
#include "pbrt/samplers/block_sampler.h"
#include "pbrt/samplers/joint_orders.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {

namespace {

/// The bits of v at the even places.
constexpr uint64_t SpreadBits(uint32_t v) {
    uint64_t x = v;
    x = (x | (x << 16)) & 0x0000ffff0000ffffull;
    x = (x | (x << 8)) & 0x00ff00ff00ff00ffull;
    x = (x | (x << 4)) & 0x0f0f0f0f0f0f0f0full;
    x = (x | (x << 2)) & 0x3333333333333333ull;
    return (x | (x << 1)) & 0x5555555555555555ull;
}

/// The permutations of {0, 1, 2, 3}, two bits for each image.
constexpr std::array<uint8_t, 24> kPermutations = [] {
    std::array<uint8_t, 24> table{};
    size_t n = 0;
    for (unsigned a = 0; a < 4; ++a)
        for (unsigned b = 0; b < 4; ++b)
            for (unsigned c = 0; c < 4; ++c)
                if (a != b && b != c && a != c)
                    table[n++] = uint8_t(a | b << 2 | c << 4 | (6 - a - b - c) << 6);
    return table;
}();

class ZSobolSampler final : public BlockSampler {
  public:
    ZSobolSampler(int log2SamplesPerPixel, Int2 resolution, Randomization randomization, int seed)
        : BlockSampler(seed), log2Samples_(log2SamplesPerPixel), randomization_(randomization) {
        while (levels_ < 30 && (1 << levels_) < std::max(resolution.x, resolution.y)) ++levels_;
        for (int d = 0; d <= kDimensions; ++d) keys_[size_t(d)] = Hash(seed, d);
    }
    int SamplesPerPixel() const override { return 1 << log2Samples_; }
    int NextGoodCount(int samples) const override { return NextCountOfNets(samples); }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<ZSobolSampler>(*this); }

  protected:
    void StartPixel() override {
        morton_ = SpreadBits(uint32_t(Pixel().x)) | SpreadBits(uint32_t(Pixel().y)) << 1;
    }

    void Fill1D(int dimension, Lanes& x) override {
        std::array<uint32_t, kLanes> v = Indices(dimension);
        RandomizeReversed(randomization_, uint32_t(keys_[size_t(dimension)] >> 32), v);
        for (size_t l = 0; l < kLanes; ++l) x[l] = UnitFloat32(ReverseBits(v[l]));
    }

    void Fill2D(int dimension, Lanes& x, Lanes& y) override {
        const uint64_t scramble = keys_[size_t(dimension)];
        std::array<uint32_t, kLanes> v = Indices(dimension), w;
        for (size_t l = 0; l < kLanes; ++l) w[l] = SobolSecond(v[l]);
        RandomizeReversed(randomization_, uint32_t(scramble >> 32), v);
        RandomizeReversed(randomization_, uint32_t(scramble), w);
        for (size_t l = 0; l < kLanes; ++l) {
            x[l] = UnitFloat32(ReverseBits(v[l]));
            y[l] = UnitFloat32(ReverseBits(w[l]));
        }
    }

  private:
    /// Dimensions that have their points in common: the last one is of those with joint orders, and every
    /// other dimension has one of its own.
    struct Group {
        uint64_t pixel = 0;       ///< tag of the pixel that the next three are for
        uint64_t morton = 0;      ///< its number along the curve
        uint64_t index = 0;       ///< that number with all quadrants permuted
        uint64_t keyOfPixel = 0;  ///< for its own quadrants
        int first = -1;           ///< sample of the block that the indices are of
        std::array<uint32_t, kLanes> indices{};
    };
    static constexpr size_t kJoint = kDimensions;
    /// Orders of dimensions, -1 for those that are alone.
    static constexpr std::array<int, kDimensions> kOrders = [] {
        std::array<int, kDimensions> orders{};
        orders.fill(-1);
        for (int i = 0; i < JointOrders::kCount; ++i) orders[size_t(JointOrders::kDimensions[size_t(i)])] = i;
        return orders;
    }();

    /// Permutation at a node of the quadtree, `key` being that of the node.
    static unsigned PermutationOf(uint64_t key) { return kPermutations[((MixBits(key) >> 32) * 24) >> 32]; }
    static uint64_t NodeKey(uint64_t key, uint64_t node, int level) {
        return key ^ (node << 6 | uint64_t(level));
    }

    void StartPixelOf(size_t number) {
        Group& group = groups_[number];
        const uint64_t key = keys_[number];
        // Above the level where this pixel parts from the last one, the two have the same quadrants.
        int level = group.pixel == 0 ? levels_ : (int(std::bit_width(morton_ ^ group.morton)) + 1) / 2;
        level = std::min(level, levels_);
        uint64_t index = group.index >> (2 * level);
        while (level-- > 0) {
            const uint64_t node = morton_ >> (2 * level);
            const unsigned permutation = PermutationOf(NodeKey(key, node >> 2, level));
            index = index << 2 | ((permutation >> (2 * (node & 3))) & 3);
        }
        group = {.pixel = PixelTag(), .morton = morton_, .index = index, .keyOfPixel = Hash(key, morton_)};
    }

    void StartBlockOf(Group& group) const {
        group.first = FirstIndex();
        const auto first = uint32_t(FirstIndex());
        // Digits that the whole block has in common.
        auto common = uint32_t(group.index << log2Samples_);
        int shift = log2Samples_ - 2;
        for (; shift > 2; shift -= 2) {
            const unsigned permutation =
                PermutationOf(NodeKey(group.keyOfPixel, first >> (shift + 2), shift));
            common |= ((permutation >> (2 * ((first >> shift) & 3))) & 3) << shift;
        }
        std::array<uint32_t, kLanes>& indices = group.indices;
        indices.fill(common);

        // Digits that differ; each half of the block lies below one node.
        for (; shift >= 0; shift -= 2)
            for (uint32_t half = 0; half < kLanes; half += 4) {
                const unsigned permutation =
                    PermutationOf(NodeKey(group.keyOfPixel, (first + half) >> (shift + 2), shift));
                for (uint32_t l = half; l < half + 4; ++l)
                    indices[l] |= ((permutation >> (2 * (((first + l) >> shift) & 3))) & 3) << shift;
            }
        // An odd power of two leaves one binary digit.
        if (shift == -1) {
            const auto flips = uint32_t(MixBits(NodeKey(group.keyOfPixel, first >> 3, 63)) >> 32);
            for (uint32_t l = 0; l < kLanes; ++l) indices[l] |= (l ^ (flips >> (l >> 1))) & 1;
        }
    }

    /// Orders tell as many points apart as they have bits, and would then make the same ones again: in all
    /// dimensions, for each block of so many indices. So each takes its points from another place.
    uint32_t ShiftOf(int dimension, uint32_t index) const {
        static_assert((1 << JointOrders::kBits) > kLanes);
        const uint64_t block = index >> JointOrders::kBits;
        return uint32_t(MixBits(keys_[size_t(dimension)] ^ (block << 32 | 1))) &
               ((1 << JointOrders::kBits) - 1);
    }

    /// Sobol indices of the block's samples.
    std::array<uint32_t, kLanes> Indices(int dimension) {
        const int orderNumber = kOrders[size_t(dimension)];
        const size_t groupNumber = orderNumber < 0 ? size_t(dimension) : kJoint;
        Group& group = groups_[groupNumber];
        if (group.pixel != PixelTag()) StartPixelOf(groupNumber);
        if (group.first != FirstIndex()) StartBlockOf(group);
        if (orderNumber < 0) return group.indices;
        const JointOrders::Order& order = orders_->Of(orderNumber);
        const uint32_t shift = ShiftOf(dimension, group.indices[0]);
        std::array<uint32_t, kLanes> indices;
        for (size_t l = 0; l < kLanes; ++l) indices[l] = order(group.indices[l]) ^ shift;
        return indices;
    }

    int log2Samples_;
    int levels_ = 0;  ///< of the quadtree over the image
    Randomization randomization_;
    uint64_t morton_ = 0;
    const JointOrders* orders_ = &JointOrders::Get();
    std::array<uint64_t, kDimensions + 1> keys_{};  ///< of groups; scrambles of dimensions as well
    std::array<Group, kDimensions + 1> groups_{};
};

std::unique_ptr<Sampler> CreateZSobol(const SamplerArgs& args) {
    const int samplesPerPixel = ReadPixelSamples(args, 16);
    const int log2Samples = int(std::bit_width(unsigned(samplesPerPixel))) - 1;
    if (!args.samplesPerPixel && !std::has_single_bit(unsigned(samplesPerPixel)) && args.observer)
        args.observer->Warn(
            fmt::format("{}: warning: sampler \"zsobol\" takes {} samples per pixel, the largest "
                        "power of two in {}",
                        args.params.LocOf("pixelsamples").ToString(), 1 << log2Samples, samplesPerPixel));
    const Randomization randomization = ReadRandomization(args, BinaryRandomizations());
    return std::make_unique<ZSobolSampler>(log2Samples, args.resolution, randomization, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "zsobol", CreateZSobol);

}  // namespace lacquer
