// Random stacks with a pair of directions each: what a rule that chooses between estimators is judged by.
// Knows no test framework: a benchmark uses the same ones.
#pragma once

#include "layered/stack_cases.h"

namespace lacquer::layered::test {

/// A stack of rough interfaces and slabs that absorb at most, and two directions outside of it.
struct RandomQuery {
    StackCase row;  ///< its name tells the stack in words
    Vec3 wo, wi;
    bool isOnLobe = false;  ///< wi was found by following light through the stack; else it is independent

    /// Stack and directions.
    std::string Describe() const;
};

/// One or two coats over metal, mirror or dielectric; a half of each facets' distribution, one stack in ten
/// has both. Alphas are log-uniform in [0.005, 1], indices in [1.1, 2.5], a quarter of them the other way up;
/// slabs absorb in three of ten. Cosines are uniform in [0.02, 1] for a half of the directions and
/// log-uniform for the other one. wi is on the side of wo or, where light passes, with a chance of one half
/// on the other one. The same seed, the same query.
/// @param isTurned  a half of the interfaces are anisotropic then, by a factor of up to 8 and turned to any
///                  side, and two thirds have perturbed normals, by up to 22 degrees
RandomQuery MakeRandomQuery(uint64_t seed, bool isTurned = false);

}  // namespace lacquer::layered::test
