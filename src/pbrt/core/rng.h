// Hashes and pseudo-random numbers. All state is a value that the caller owns.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "pbrt/core/math.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Bijective mixing of 64 bits: the finaliser of splitmix64 [Steele et al. 2014, variant 13 of Stafford].
constexpr uint64_t MixBits(uint64_t v) {
    v ^= v >> 30;
    v *= 0xbf58476d1ce4e5b9ull;
    v ^= v >> 27;
    v *= 0x94d049bb133111ebull;
    return v ^ (v >> 31);
}

/// Hash of any number of trivially copyable values of at most 8 bytes each.
template <class... Values>
uint64_t Hash(Values... values) {
    uint64_t h = 0x9e3779b97f4a7c15ull;
    const auto add = [&h](auto value) {
        uint64_t bits = 0;
        static_assert(sizeof(value) <= 8);
        std::memcpy(&bits, &value, sizeof(value));
        h = MixBits(h ^ bits) + 0x9e3779b97f4a7c15ull;
    };
    (add(values), ...);
    return MixBits(h);
}
/// The same for vectors: their components in turn.
inline uint64_t Hash(Vec3 a, Vec3 b) { return Hash(a.x, a.y, a.z, b.x, b.y, b.z); }

/// The upper 24 bits of a hash as a float in [0,1).
constexpr float UnitFloat(uint64_t hash) { return float(hash >> 40) * 0x1p-24f; }

/// Numbers in [0,1) that a generator gives before its own: dimensions of stratified points, a block at a time
/// as they are asked for. Users take them in parts, such as the steps of a walk: each part starts a block, so
/// what one part takes shifts nothing in those after it.
class LeadingNumbers {
  public:
    static constexpr size_t kBlock = 8;
    using Block = std::array<float, kBlock>;

    LeadingNumbers(const LeadingNumbers&) = delete;
    LeadingNumbers& operator=(const LeadingNumbers&) = delete;
    /// The next one or two of the current part; null if it has no more. Pairs come from one block: of an odd
    /// rest the last number is left out.
    const float* Take(size_t count) {
        if (next_ + count > kBlock) {
            if (!Fill(&block_)) return nullptr;
            next_ = 0;
        }
        const float* first = &block_[next_];
        next_ += count;
        return first;
    }
    /// Begins the next part.
    void StartPart() {
        next_ = kBlock;
        DoStartPart();
    }

  protected:
    LeadingNumbers() = default;
    ~LeadingNumbers() = default;
    /// The next block of the part. False if there is none.
    virtual bool Fill(Block* block) = 0;
    virtual void DoStartPart() = 0;

  private:
    size_t next_ = kBlock;
    alignas(32) Block block_;
};

/// Pseudo-random numbers: a 64-bit counter through MixBits (splitmix64). Seeded in one step, no state to warm
/// up. Seeds should come from Hash(): two that differ by a multiple of the counter's step give shifted copies
/// of one stream.
class Rng {
  public:
    Rng() = default;
    explicit Rng(uint64_t seed) : state_(seed) {}
    /// @param leading  what Uniform() and Uniform2D() give first, for this generator and its copies together;
    ///                 outlives them
    Rng(uint64_t seed, LeadingNumbers& leading) : state_(seed), leading_(&leading), source_(&leading) {}
    uint64_t NextBits() { return MixBits(state_ += kStep); }
    /// How many numbers, leading ones apart, this generator has given since it was `earlier`.
    uint64_t CountSince(const Rng& earlier) const { return (state_ - earlier.state_) * kInverseStep; }
    /// Uniform in [0,1).
    float Uniform() {
        if (const float* u = TakeLeading(1)) return *u;
        return UnitFloat(NextBits());
    }
    Point2 Uniform2D() {
        if (const float* u = TakeLeading(2)) return {u[0], u[1]};
        const uint64_t bits = NextBits();
        return {float(bits >> 40) * 0x1p-24f, float((bits >> 8) & 0xffffff) * 0x1p-24f};
    }
    /// Uniform integer in [0, n), n > 0; the bias is below n / 2^32.
    uint32_t UniformInt(uint32_t n) { return uint32_t(((NextBits() >> 32) * n) >> 32); }

    /// True if the next numbers are, or may be, leading ones.
    bool HasLeading() const { return leading_ != nullptr; }
    /// Goes on with the next part of the leading numbers, if this generator has any.
    void StartPart() {
        if (!source_) return;
        source_->StartPart();
        leading_ = source_;
    }

  private:
    static constexpr uint64_t kStep = 0x9e3779b97f4a7c15ull, kInverseStep = 0xf1de83e19937733dull;
    static_assert(kStep * kInverseStep == 1);

    const float* TakeLeading(size_t count) {
        if (!leading_) return nullptr;
        const float* u = leading_->Take(count);
        if (!u) leading_ = nullptr;
        return u;
    }

    uint64_t state_ = 0;
    LeadingNumbers* leading_ = nullptr;  ///< null: the part has no more
    LeadingNumbers* source_ = nullptr;
};

/// Image of i under a pseudo-random permutation of [0, length) chosen by `seed` [Kensler 2013].
inline uint32_t PermutationElement(uint32_t i, uint32_t length, uint32_t seed) {
    if (length <= 1) return 0;
    uint32_t mask = length - 1;
    mask |= mask >> 1;
    mask |= mask >> 2;
    mask |= mask >> 4;
    mask |= mask >> 8;
    mask |= mask >> 16;
    // Rounds of operations that are each invertible on mask+1 values; values outside are walked on.
    do {
        i ^= seed;
        i *= 0xe170893d;
        i ^= seed >> 16;
        i ^= (i & mask) >> 4;
        i ^= seed >> 8;
        i *= 0x0929eb3f;
        i ^= seed >> 23;
        i ^= (i & mask) >> 1;
        i *= 1 | seed >> 27;
        i *= 0x6935fa69;
        i ^= (i & mask) >> 11;
        i *= 0x74dcb303;
        i ^= (i & mask) >> 2;
        i *= 0x9e501cc3;
        i ^= (i & mask) >> 2;
        i *= 0xc860a3df;
        i &= mask;
        i ^= i >> 5;
    } while (i >= length);
    // Rotate by the seed, without the sum that would wrap at 2^32 and meet values twice.
    const uint32_t shift = seed % length, room = length - shift;
    return i < room ? i + shift : i - room;
}

}  // namespace lacquer
