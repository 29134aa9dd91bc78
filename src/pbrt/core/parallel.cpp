#include "pbrt/core/parallel.h"

#include "pbrt/core/parallel_loop.h"
#include "pbrt/core/scattered_order.h"

namespace lacquer {
void ParallelTiles(const Bounds2i& bounds, int size, TileOrder order,
                   const std::function<void(const Bounds2i&)>& body) {
    if (bounds.IsEmpty()) return;
    const int columns = (bounds.Width() + size - 1) / size, rows = (bounds.Height() + size - 1) / size;
    const int64_t count = int64_t(columns) * rows;
    const int64_t stride = order == TileOrder::Rows ? 1 : ScatteringStride(count);
    RunLoop(count, Grain::One, [&](int64_t k) {
        const int64_t i = k * stride % count;
        const Int2 corner = bounds.min + size * Int2(int(i % columns), int(i / columns));
        body({corner, glm::min(corner + size, bounds.max)});
    });
}

void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) {
    RunLoop(count, Grain::Any, body);
}

void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b) {
    RunLoop(2, Grain::One, [&](int64_t i) { i == 0 ? a() : b(); });
}

}  // namespace lacquer
