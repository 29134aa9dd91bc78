// 16-bit floats (IEEE 754 binary16) as bit patterns.
#pragma once

#include <bit>
#include <cstdint>

namespace lacquer {

/// Largest finite 16-bit float.
inline constexpr float kMaxHalf = 65504;

/// Exact. O(1).
inline float HalfToFloat(uint16_t h) {
    // Exponent and mantissa move to their float places; the product fixes the bias, also of denormal numbers.
    const uint32_t magnitude = uint32_t(h & 0x7fff) << 13, sign = uint32_t(h & 0x8000) << 16;
    uint32_t bits = std::bit_cast<uint32_t>(std::bit_cast<float>(magnitude) * 0x1p112f);
    if (magnitude >= 0x0f800000) bits |= 0x7f800000;  // infinity and NaN
    return std::bit_cast<float>(bits | sign);
}

/// Rounds to nearest, ties to even; beyond kMaxHalf becomes infinity, NaN stays NaN. O(1).
inline uint16_t FloatToHalf(float f) {
    const uint32_t all = std::bit_cast<uint32_t>(f);
    const auto sign = uint16_t((all >> 16) & 0x8000);
    const uint32_t bits = all & 0x7fffffff;
    if (bits > 0x7f800000) return uint16_t(sign | 0x7e00);
    if (bits >= 0x477ff000) return uint16_t(sign | 0x7c00);
    if (bits < 0x38800000) {
        // Denormal: adding 2^-1 puts one unit of 2^-24 at the last place of the sum, which rounds it.
        const float shifted = std::bit_cast<float>(bits) + 0.5f;
        return uint16_t(sign | (std::bit_cast<uint32_t>(shifted) - 0x3f000000));
    }
    const uint32_t odd = (bits >> 13) & 1;
    return uint16_t(sign | ((bits - 0x38000000 + 0xfff + odd) >> 13));
}

}  // namespace lacquer
