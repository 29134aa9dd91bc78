#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "pbrt/core/parallel.h"
#include "pbrt/core/parallel_loop.h"

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

void RunLoop(int64_t count, Grain grain, const std::function<void(int64_t)>& body) {
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] {
        if (grain == Grain::Any) {
            tbb::parallel_for(int64_t(0), count, body);
            return;
        }
        tbb::parallel_for(
            tbb::blocked_range<int64_t>(0, count, 1),
            [&](const tbb::blocked_range<int64_t>& range) {
                for (int64_t i = range.begin(); i < range.end(); ++i) body(i);
            },
            tbb::simple_partitioner());
    });
}

}  // namespace lacquer
