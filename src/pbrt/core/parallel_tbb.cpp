#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <utility>

#include "pbrt/core/parallel.h"
#include "pbrt/core/parallel_loop.h"

namespace lacquer {

namespace {

thread_local bool isInLoop = false;

/// As long as a thread is at work in a loop.
class LoopGuard {
  public:
    LoopGuard() : before_(std::exchange(isInLoop, true)) {}
    ~LoopGuard() { isInLoop = before_; }
    LoopGuard(const LoopGuard&) = delete;
    LoopGuard& operator=(const LoopGuard&) = delete;

  private:
    bool before_;
};

void LoopHere(int64_t count, Grain grain, const std::function<void(int64_t)>& body) {
    const tbb::blocked_range<int64_t> all(0, count, 1);
    const auto work = [&](const tbb::blocked_range<int64_t>& range) {
        const LoopGuard guard;
        for (int64_t i = range.begin(); i < range.end(); ++i) body(i);
    };
    if (grain == Grain::Any)
        tbb::parallel_for(all, work);
    else
        tbb::parallel_for(all, work, tbb::simple_partitioner());
}

}  // namespace

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
    // A loop inside of another goes by the same threads. Each with an arena of its own, thousands of small
    // ones would wait for each other; and a thread that waits for its end takes no step of the outer loop.
    if (isInLoop) {
        tbb::this_task_arena::isolate([&] { LoopHere(count, grain, body); });
        return;
    }
    tbb::task_arena arena(MaxThreads());
    arena.execute([&] { LoopHere(count, grain, body); });
}

}  // namespace lacquer
