// Powers of many numbers.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

namespace lacquer::estimate {

/// Calls store(i, base(i)^exponent) for all i < count, by Eigen's vectors. In an aligned block that is always
/// whole, so that the bits do not depend on where numbers lie in memory.
/// @param base  positive values
template <class Base, class Store>
void ForEachPower(size_t count, double exponent, const Base& base, const Store& store) {
    constexpr size_t kBlock = 1024;
    Eigen::Array<double, kBlock, 1> block;
    for (size_t first = 0; first < count; first += kBlock) {
        const size_t n = std::min(kBlock, count - first);
        for (size_t i = 0; i < kBlock; ++i) block[Eigen::Index(i)] = i < n ? base(first + i) : 1;
        block = (block.log() * exponent).exp();
        for (size_t i = 0; i < n; ++i) store(first + i, block[Eigen::Index(i)]);
    }
}

}  // namespace lacquer::estimate
