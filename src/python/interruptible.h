// Long work beside the interpreter: other threads of Python run on, Ctrl-C stops it, and a callback hears of
// it.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "pbrt/core/progress.h"

namespace lacquer::python {

/// What work tells about itself, kept until someone asks.
class Notices final : public Observer {
  public:
    struct State {
        std::string stage;
        int64_t done = 0, total = 0;
    };

    void Begin(const std::string& name, int64_t total, const std::string& unit) override;
    void Advance(int64_t units) override { done_ += units; }
    void Warn(const std::string& message) override;
    bool ShouldStop() override { return stops_; }

    void Stop() { stops_ = true; }
    State Now() const;
    /// Each of them once.
    std::vector<std::string> Warnings() const;

  private:
    mutable std::mutex mutex_;
    std::string stage_;
    int64_t total_ = 0;
    std::atomic<int64_t> done_ = 0;
    std::atomic<bool> stops_ = false;
    std::vector<std::string> warnings_;
};

/// Runs `work` on a thread of its own while this one, without the interpreter's lock, looks for signals some
/// fifty times a second and tells `progress` what `notices` knows; a last time when the work has ended. If
/// the callback returns False, the work is asked to stop, and returns by itself. If it raises, or a signal's
/// handler does (as for Ctrl-C), the work is stopped and the exception goes on. Exceptions of the work are
/// rethrown.
/// @param progress  called with (stage, done, total) on the thread that called; None: nobody is told
void RunInterruptibly(Notices& notices, const pybind11::object& progress, const std::function<void()>& work);

/// One render at a time in a process: they share its threads. Waits for others without the interpreter's
/// lock; a signal ends the waiting. Errors: UsageError in a progress callback of a render, which would wait
/// for itself.
class RenderTurn {
  public:
    RenderTurn();
    ~RenderTurn();
    RenderTurn(const RenderTurn&) = delete;
    RenderTurn& operator=(const RenderTurn&) = delete;
};

}  // namespace lacquer::python
