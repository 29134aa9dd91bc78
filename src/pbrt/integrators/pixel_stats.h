// What each pixel costs: the option "pixelstats".
#pragma once

#include <chrono>
#include <vector>

#include "pbrt/base/integrator.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// Costs of the pixels of a film, summed over their samples. Pixels may be worked on by several threads, as
/// long as no two work on one.
class PixelStats {
  public:
    explicit PixelStats(const Bounds2i& bounds) : bounds_(bounds), pixels_(size_t(bounds.Area())) {}

    /// Runs `render`, which takes samples of the pixel with this thread's `state`, and adds what that cost.
    template <class Function>
    void Measure(Int2 pixel, const ThreadState& state, const Function& render) {
        const Costs before = CountersOf(state);
        const auto start = std::chrono::steady_clock::now();
        render();
        const Costs after = CountersOf(state);
        Costs& sum = pixels_[size_t(pixel.y - bounds_.min.y) * size_t(bounds_.Width()) +
                             size_t(pixel.x - bounds_.min.x)];
        sum.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        sum.rays += after.rays - before.rays;
        sum.shadowRays += after.shadowRays - before.shadowRays;
        sum.vertices += after.vertices - before.vertices;
    }
    /// Channels time [s], rays (to nearest hits), shadowrays, and vertices that scatter light. `bounds` is
    /// the data window. @param fullResolution  of the film
    std::unique_ptr<Image> Develop(Int2 fullResolution) const;

  private:
    struct Costs {
        double seconds = 0;
        int64_t rays = 0, shadowRays = 0, vertices = 0;
    };
    static Costs CountersOf(const ThreadState& state) {
        return {0, state.rays.nearest, state.rays.shadow, state.pathLengthSum};
    }

    Bounds2i bounds_;
    std::vector<Costs> pixels_;
};

}  // namespace lacquer
