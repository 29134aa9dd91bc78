// A thread that renders units of work, while the thread that made it exchanges messages.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "cmd/mpi/unit_ledger.h"
#include "pbrt/core/progress.h"
#include "pbrt/integrators/render.h"

namespace lacquer::cmd {

/// What became of a unit.
struct RenderedUnit {
    RenderUnit unit;
    mpi::Bytes state;   ///< StateBytes() of a film of its pixels
    RenderStats stats;  ///< seconds and counters
};

/// Renders units one after another, in the order in which they are put.
class UnitRenderer {
  public:
    /// @param render  of one unit; stops soon once its observer says so, and is then of no interest
    using Renderer = std::function<RenderedUnit(const RenderUnit& unit, Observer& observer)>;
    explicit UnitRenderer(Renderer render);
    /// Stops amid a unit.
    ~UnitRenderer();
    UnitRenderer(const UnitRenderer&) = delete;
    UnitRenderer& operator=(const UnitRenderer&) = delete;

    void Put(const RenderUnit& unit);
    /// The next unit that is finished. Rethrows what rendering has thrown.
    std::optional<RenderedUnit> TryTake();
    /// Waits until one is finished, or for a while. @param seconds  at most
    void Wait(double seconds);

  private:
    struct StopObserver final : Observer {
        std::atomic<bool> stops = false;
        bool ShouldStop() override { return stops; }
    };
    void Loop();

    Renderer render_;
    StopObserver observer_;
    std::mutex mutex_;
    std::condition_variable changed_, finished_;
    std::deque<RenderUnit> todo_;
    std::deque<RenderedUnit> done_;
    std::exception_ptr error_;
    std::thread thread_;  ///< last: it uses the others
};

}  // namespace lacquer::cmd
