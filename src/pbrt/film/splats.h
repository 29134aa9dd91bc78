// Light that lands on pixels which no thread owns.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "pbrt/base/filter.h"
#include "pbrt/core/vec.h"
#include "pbrt/film/exact_sums.h"

namespace lacquer {

/// Sums of splats, one set for each thread: the image does not depend on which thread had which splat. 51
/// bytes a pixel and thread, from the thread's first splat on.
class SplatSums {
  public:
    /// Bytes that all threads together may take.
    static constexpr size_t kMaxBytes = size_t(4) << 30;

    /// Does nothing the second time. Errors: OverrideError beyond kMaxBytes.
    void Prepare(const Bounds2i& bounds, int threads);
    /// Adds `value` times the filter to each pixel whose filter reaches p. For the calling thread of a
    /// parallel loop. `value` finite.
    void Add(Point2 p, Vec3 value, const Filter& filter);
    /// Sum over all threads at pixel number `i` in rows of the bounds; not while others add.
    glm::dvec3 Sum(size_t i) const;
    /// All sums, of which those of all threads become the first one's; not while others add.
    ExactSums& Gathered();
    bool IsPrepared() const { return !threads_.empty(); }
    size_t Bytes() const;

  private:
    Bounds2i bounds_;
    /// On cache lines of their own.
    struct alignas(128) Sums {
        ExactSums pixels;
    };
    std::vector<Sums> threads_;
};

}  // namespace lacquer
