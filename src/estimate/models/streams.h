// Random numbers of a seed: a stream of its own for each component of each model.
#pragma once

#include <cstdint>

#include "pbrt/core/rng.h"

namespace lacquer::estimate {

/// What a seed makes. The numbers are part of what a seed means: append, do not reorder.
enum class Component : uint32_t { Phase = 1, Cells, Noise, Shift, Flakes, RingWidths, Grain, Distortion };

/// Seed of the stream of one component. Maps of one component do not depend on what others consume.
/// @param model  number of the model
inline uint64_t StreamOf(uint64_t seed, uint32_t model, Component component) {
    return Hash(seed, model, uint32_t(component));
}
/// Number in [0,1) of a place of a stream: the upper 53 bits of a hash.
inline double UnitAt(uint64_t stream, int32_t i, int32_t j) {
    return double(MixBits(stream ^ MixBits(uint64_t(uint32_t(i)) << 32 | uint32_t(j))) >> 11) * 0x1p-53;
}
/// The next number in [0,1) of a generator, with 53 bits.
inline double UnitDouble(Rng* rng) { return double(rng->NextBits() >> 11) * 0x1p-53; }

}  // namespace lacquer::estimate
