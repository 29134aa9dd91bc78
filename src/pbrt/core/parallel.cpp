#include "pbrt/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

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

void ParallelFor(int64_t count, const std::function<void(int64_t)>& body) {
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] { tbb::parallel_for(int64_t(0), count, body); });
}

void ParallelTiles(const Bounds2i& bounds, int size, const std::function<void(const Bounds2i&)>& body) {
    if (bounds.IsEmpty()) return;
    const int columns = (bounds.Width() + size - 1) / size, rows = (bounds.Height() + size - 1) / size;
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<int64_t>(0, int64_t(columns) * rows, 1),
            [&](const tbb::blocked_range<int64_t>& range) {
                for (int64_t i = range.begin(); i < range.end(); ++i) {
                    const Int2 corner = bounds.min + size * Int2(int(i % columns), int(i / columns));
                    body({corner, glm::min(corner + size, bounds.max)});
                }
            },
            tbb::simple_partitioner());
    });
}

}  // namespace lacquer
