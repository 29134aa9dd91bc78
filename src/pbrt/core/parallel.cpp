#include "pbrt/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <numeric>

namespace lacquer {

ThreadLimit::ThreadLimit(int threads) : threads_(threads > 0 ? threads : tbb::info::default_concurrency()) {
    control_ = new tbb::global_control(tbb::global_control::max_allowed_parallelism, size_t(threads_));
}

ThreadLimit::~ThreadLimit() { delete static_cast<tbb::global_control*>(control_); }

int ThreadIndex() { return std::max(0, tbb::this_task_arena::current_thread_index()); }

int MaxThreads() {
    // More threads than processors may be asked for; the arena then has that many slots.
    return std::max(tbb::this_task_arena::max_concurrency(),
                    int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)));
}

int AllowedThreads() {
    return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) {
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] { tbb::parallel_for(int64_t(0), count, body); });
}

namespace {

/// A step through [0, count) by about the golden ratio that visits all: its multiples stay far apart.
int64_t ScatteringStride(int64_t count) {
    int64_t stride = std::max(int64_t(1), int64_t(0.6180339887 * double(count)));
    while (std::gcd(stride, count) != 1) ++stride;
    return stride;
}

}  // namespace

void ParallelTiles(const Bounds2i& bounds, int size, TileOrder order,
                   const std::function<void(const Bounds2i&)>& body) {
    if (bounds.IsEmpty()) return;
    const int columns = (bounds.Width() + size - 1) / size, rows = (bounds.Height() + size - 1) / size;
    const int64_t count = int64_t(columns) * rows;
    const int64_t stride = order == TileOrder::Rows ? 1 : ScatteringStride(count);
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<int64_t>(0, count, 1),
            [&](const tbb::blocked_range<int64_t>& range) {
                for (int64_t k = range.begin(); k < range.end(); ++k) {
                    const int64_t i = k * stride % count;
                    const Int2 corner = bounds.min + size * Int2(int(i % columns), int(i / columns));
                    body({corner, glm::min(corner + size, bounds.max)});
                }
            },
            tbb::simple_partitioner());
    });
}

}  // namespace lacquer
