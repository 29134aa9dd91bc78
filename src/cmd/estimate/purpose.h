// What `estimate` draws random numbers for, beside its simulations.
#pragma once

#include <cstdint>

namespace lacquer::cmd {

/// Each has a stream of its own, and the simulations have that of the seed itself. Whoever changes a number
/// changes the bits of all results.
enum class Purpose : uint64_t {
    // Photographs.
    PhotoChains = 101,
    Predictions,
    Images,
    Maps,
    PhotoProducts,
    Kinds,
    // Photographs by surfaces of fixed seeds.
    FixedSeeds = 201,
    Scatter,
    Modes,
    FixedSeedChains,
    Starts,
    // Layers.
    LayeredChains = 301,
    LayeredProducts,
    Candidates = 304,
};

}  // namespace lacquer::cmd
