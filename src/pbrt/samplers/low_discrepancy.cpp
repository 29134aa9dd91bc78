#include "pbrt/samplers/low_discrepancy.h"

#include <charconv>
#include <string_view>

#include "pbrt/core/check.h"
#include "pbrt/core/embedded.h"

namespace lacquer {

namespace {

// One for each index of a progression.
using LaneInts = int32_t __attribute__((vector_size(4 * RadicalInverse::kLanes)));
using LaneFloats = float __attribute__((vector_size(4 * RadicalInverse::kLanes)));
using LaneDoubles = double __attribute__((vector_size(8 * RadicalInverse::kLanes)));

/// The integers at the start of a line.
std::vector<uint32_t> IntegersOf(std::string_view line) {
    std::vector<uint32_t> numbers;
    const char *at = line.data(), *const end = at + line.size();
    while (true) {
        while (at != end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
        uint32_t number = 0;
        const auto [next, error] = std::from_chars(at, end, number);
        if (error != std::errc()) return numbers;
        numbers.push_back(number);
        at = next;
    }
}

/// Direction numbers from a row {d, s, a, m_1 .. m_s} by the recurrence of [Bratley and Fox 1988].
SobolColumns ColumnsOf(const std::vector<uint32_t>& row) {
    const size_t degree = row[1];
    const uint32_t a = row[2];
    LACQUER_CHECK(degree >= 1 && degree < 32 && row.size() == 3 + degree);
    SobolColumns v{};
    for (size_t k = 0; k < v.size(); ++k) {
        if (k < degree) {
            v[k] = row[3 + k] << (31 - k);
            continue;
        }
        v[k] = v[k - degree] ^ (v[k - degree] >> degree);
        for (size_t i = 1; i < degree; ++i)
            if ((a >> (degree - 1 - i)) & 1) v[k] ^= v[k - i];
    }
    for (uint32_t& column : v) column = ReverseBits(column);
    return v;
}

}  // namespace

uint32_t OwenReversed(uint32_t v, uint32_t seed) {
    uint32_t flips = 0;
    for (int bit = 0; bit < 24; ++bit) {
        // The digits above this one name the node of the tree; a one above them tells the levels apart.
        const uint32_t node = (v & ((1u << bit) - 1)) | (1u << bit);
        flips |= uint32_t(MixBits((uint64_t(seed) << 32 | node) * 0x9e3779b97f4a7c15ull) >> 63) << bit;
    }
    return (v ^ flips) & 0xffffff;
}

std::vector<SobolColumns> MakeSobolMatrices(int dimensions) {
    std::vector<SobolColumns> matrices(1);
    for (size_t k = 0; k < 32; ++k) matrices[0][k] = 1u << k;
    std::string_view text = EmbeddedData("sobol/joe-kuo-d6.txt");
    while (!text.empty() && int(matrices.size()) < dimensions) {
        const size_t length = std::min(text.find('\n'), text.size());
        const std::vector<uint32_t> row = IntegersOf(text.substr(0, length));
        text.remove_prefix(std::min(length + 1, text.size()));
        if (row.empty()) continue;
        LACQUER_CHECK(row.size() > 3 && row[0] == matrices.size() + 1);
        matrices.push_back(ColumnsOf(row));
    }
    LACQUER_CHECK(int(matrices.size()) == dimensions);
    return matrices;
}

std::vector<int> FirstPrimes(int count) {
    std::vector<int> primes;
    for (int n = 2; int(primes.size()) < count; ++n) {
        bool isPrime = true;
        for (const int p : primes) {
            if (p * p > n) break;
            if (n % p == 0) {
                isPrime = false;
                break;
            }
        }
        if (isPrime) primes.push_back(n);
    }
    return primes;
}

RadicalInverse::RadicalInverse(int base, bool permute, uint64_t seed) {
    LACQUER_CHECK(base >= 2 && base <= 1024);
    // Take as many digits at a time as a small table holds.
    constexpr uint64_t kMaxChunk = 2304;  // three digits of 13, two of 47
    int digitsPerChunk = 1;
    chunkSize_ = uint64_t(base);
    while (chunkSize_ * uint64_t(base) <= kMaxChunk) {
        chunkSize_ *= uint64_t(base);
        ++digitsPerChunk;
    }
    reciprocal_ = ~uint64_t(0) / chunkSize_ + 1;

    // Tabulate each chunk with its digits permuted, the first one becoming the most significant.
    constexpr double kMinWeight = 0x1p-24;
    int position = 0;
    for (double weight = 1; weight > kMinWeight; ++numChunks_) {
        for (uint64_t chunk = 0; chunk < chunkSize_; ++chunk) {
            uint64_t rest = chunk, mirrored = 0;
            for (int digit = 0; digit < digitsPerChunk; ++digit) {
                const auto value = uint32_t(rest % uint64_t(base));
                rest /= uint64_t(base);
                const auto key = uint32_t(Hash(seed, base, position + digit));
                mirrored = mirrored * uint64_t(base) +
                           (permute ? PermutationElement(value, uint32_t(base), key) : value);
            }
            digits_.push_back(uint16_t(mirrored));
        }
        LACQUER_CHECK(numChunks_ < kMaxChunks);
        weight /= double(chunkSize_);
        scales_[size_t(numChunks_)] = weight;
        position += digitsPerChunk;
    }
}

RadicalInverse::Step RadicalInverse::StepOf(uint64_t distance) const {
    Step step{};
    for (int& digits : step) {
        digits = int(distance % chunkSize_);
        distance /= chunkSize_;
    }
    return step;
}

void RadicalInverse::OfProgression(uint64_t first, const Step& step, Lanes& values) const {
    const int size = int(chunkSize_);
    const float inverse = 1 / float(size);
    const uint16_t* digits = digits_.data();
    LaneInts carries{};
    LaneDoubles sums{};
    for (size_t chunk = 0; chunk < size_t(numChunks_); ++chunk, digits += chunkSize_) {
        const uint64_t quotient = Quotient(first);
        const int digitsOfFirst = int(first - quotient * chunkSize_);
        first = quotient;
        // High digits are mostly those of the first. No lane carries more than the last one.
        if (step[chunk] == 0 && carries[kLanes - 1] == 0) {
            sums += double(digits[digitsOfFirst]) * scales_[chunk];
            continue;
        }
        // Sums are below 2^15, so that half of a unit is more than what the quotients of floats are off by.
        const LaneInts sum = LaneInts{0, 1, 2, 3, 4, 5, 6, 7} * step[chunk] + digitsOfFirst + carries;
        const LaneFloats quotients = (__builtin_convertvector(sum, LaneFloats) + 0.5f) * inverse;
        carries = __builtin_convertvector(quotients, LaneInts);
        const LaneInts places = sum - carries * size;
        LaneInts mirrored;
        for (int l = 0; l < kLanes; ++l) mirrored[l] = digits[places[l]];
        sums += __builtin_convertvector(mirrored, LaneDoubles) * scales_[chunk];
    }
    const LaneFloats rounded = __builtin_convertvector(sums, LaneFloats),
                     largest = LaneFloats{} + OneMinusEpsilon;
    values = std::bit_cast<Lanes>(rounded < largest ? rounded : largest);
}

float OwenRadicalInverse(int base, uint64_t index, uint64_t seed) {
    const auto b = uint64_t(base);
    double sum = 0, scale = 1;
    uint64_t path = 1;
    // Digits below the precision of a float make no difference.
    while (scale > 0x1p-26) {
        const uint64_t quotient = index / b, digit = index - quotient * b;
        const auto key = uint32_t(MixBits(seed ^ MixBits(path)));
        scale /= double(b);
        sum += PermutationElement(uint32_t(digit), uint32_t(base), key) * scale;
        path = path * b + digit + 1;
        index = quotient;
    }
    return std::min(float(sum), OneMinusEpsilon);
}

}  // namespace lacquer
