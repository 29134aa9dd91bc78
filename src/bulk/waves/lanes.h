// Eight numbers that the processor treats as one.
#pragma once

namespace lacquer::bulk {

using Lanes = double __attribute__((vector_size(64)));
using HalfLanes = double __attribute__((vector_size(32)));
constexpr int kNumLanes = 8;

inline Lanes Join(const HalfLanes& low, const HalfLanes& high) {
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
inline HalfLanes Low(const Lanes& v) { return __builtin_shufflevector(v, v, 0, 1, 2, 3); }
inline HalfLanes High(const Lanes& v) { return __builtin_shufflevector(v, v, 4, 5, 6, 7); }
/// The first two and the last two change places.
inline HalfLanes SwapPairs(const HalfLanes& v) { return __builtin_shufflevector(v, v, 2, 3, 0, 1); }

}  // namespace lacquer::bulk
