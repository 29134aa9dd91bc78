// An order in which any first part of a sequence is spread over the whole.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace lacquer {

/// A step through [0, count) by about the golden ratio that visits all: its multiples, modulo count, stay far
/// apart.
inline int64_t ScatteringStride(int64_t count) {
    int64_t stride = std::max(int64_t(1), int64_t(0.6180339887 * double(count)));
    while (std::gcd(stride, count) != 1) ++stride;
    return stride;
}

}  // namespace lacquer
