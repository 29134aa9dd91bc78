#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "pbrt/core/parallel.h"
#include "pbrt/core/parallel_loop.h"

namespace lacquer {
namespace {

std::atomic<int> allowedThreads = 0;  ///< 0: one for each processor
thread_local int threadIndex = 0;
thread_local bool isInLoop = false;

int Processors() { return std::max(1, int(std::thread::hardware_concurrency())); }

/// One loop, whose steps its threads take in turn.
class Loop {
  public:
    Loop(int64_t count, const std::function<void(int64_t)>& body) : count_(count), body_(body) {}

    void Work(int index) {
        threadIndex = index;
        isInLoop = true;
        try {
            for (int64_t i = next_++; i < count_; i = next_++) body_(i);
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!error_) error_ = std::current_exception();
            next_ = count_;
        }
        isInLoop = false;
        threadIndex = 0;
    }
    void Rethrow() const {
        if (error_) std::rethrow_exception(error_);
    }

  private:
    const int64_t count_;
    const std::function<void(int64_t)>& body_;
    std::atomic<int64_t> next_ = 0;
    std::mutex mutex_;
    std::exception_ptr error_;
};

}  // namespace

ThreadLimit::ThreadLimit(int threads) : threads_(threads > 0 ? threads : Processors()) {
    control_ = nullptr;  // there is nothing to hold
    allowedThreads = threads_;
}

ThreadLimit::~ThreadLimit() { allowedThreads = 0; }

int ThreadIndex() { return threadIndex; }

int AllowedThreads() { return allowedThreads > 0 ? int(allowedThreads) : Processors(); }

int MaxThreads() { return std::max(AllowedThreads(), Processors()); }

void RunLoop(int64_t count, Grain, const std::function<void(int64_t)>& body) {
    // Loops inside loops run in the thread that meets them.
    if (isInLoop) {
        for (int64_t i = 0; i < count; ++i) body(i);
        return;
    }
    Loop loop(count, body);
    std::vector<std::thread> threads;
    for (int i = 1; i < int(std::min(int64_t(AllowedThreads()), count)); ++i)
        threads.emplace_back([&loop, i] { loop.Work(i); });
    loop.Work(0);
    for (std::thread& thread : threads) thread.join();
    loop.Rethrow();
}

}  // namespace lacquer
