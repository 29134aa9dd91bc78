#include "python/interruptible.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <thread>

#include "python/errors.h"

namespace lacquer::python {

namespace py = pybind11;

namespace {

constexpr std::chrono::milliseconds kInterval(20);

std::timed_mutex turn;
thread_local bool hasTurn = false;

/// An exception of Python if a signal's handler raises one.
void CheckSignals() {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// Work on a thread of its own.
class Worker {
  public:
    explicit Worker(const std::function<void()>& work)
        : thread_([this, &work] {
              try {
                  work();
              } catch (...) {
                  failure_ = std::current_exception();
              }
              const std::lock_guard lock(mutex_);
              ended_ = true;
              changed_.notify_all();
          }) {}
    ~Worker() {
        if (thread_.joinable()) thread_.join();
    }
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// True once the work has ended.
    bool WaitFor(std::chrono::milliseconds time) {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, time, [this] { return ended_; });
    }
    void Join() { thread_.join(); }
    const std::exception_ptr& Failure() const { return failure_; }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool ended_ = false;
    std::exception_ptr failure_;
    std::thread thread_;  // last: it uses the others
};

}  // namespace

void Notices::Begin(const std::string& name, int64_t total, const std::string& /*unit*/) {
    const std::lock_guard lock(mutex_);
    stage_ = name;
    total_ = total;
    done_ = 0;
}

void Notices::Warn(const std::string& message) {
    const std::lock_guard lock(mutex_);
    if (std::find(warnings_.begin(), warnings_.end(), message) == warnings_.end())
        warnings_.push_back(message);
}

Notices::State Notices::Now() const {
    const std::lock_guard lock(mutex_);
    return {stage_, std::min<int64_t>(done_, total_), total_};
}

std::vector<std::string> Notices::Warnings() const {
    const std::lock_guard lock(mutex_);
    return warnings_;
}

void RunInterruptibly(Notices& notices, const py::object& progress, const std::function<void()>& work) {
    const auto tell = [&] {
        const Notices::State now = notices.Now();
        if (progress.is_none() || now.stage.empty()) return;
        if (progress(now.stage, now.done, now.total).ptr() == Py_False) notices.Stop();
    };
    // The exception of a callback is kept until the work has ended, since it uses what the caller owns.
    std::exception_ptr raised, failed;
    {
        const py::gil_scoped_release released;
        Worker worker(work);
        bool ended = false;
        while (!ended) {
            ended = worker.WaitFor(kInterval);
            if (raised) continue;
            const py::gil_scoped_acquire acquired;
            try {
                CheckSignals();
                if (!ended || !worker.Failure()) tell();
            } catch (...) {
                raised = std::current_exception();
                notices.Stop();
            }
        }
        worker.Join();
        failed = worker.Failure();
    }
    if (raised) std::rethrow_exception(raised);
    if (failed) std::rethrow_exception(failed);
}

RenderTurn::RenderTurn() {
    if (hasTurn) throw UsageError("a progress callback cannot render: its own render is not finished");
    for (;;) {
        {
            const py::gil_scoped_release released;
            if (turn.try_lock_for(kInterval)) break;
        }
        CheckSignals();
    }
    hasTurn = true;
}

RenderTurn::~RenderTurn() {
    hasTurn = false;
    turn.unlock();
}

}  // namespace lacquer::python
