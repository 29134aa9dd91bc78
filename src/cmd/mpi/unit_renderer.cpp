#include "cmd/mpi/unit_renderer.h"

#include <chrono>

namespace lacquer::cmd {

UnitRenderer::UnitRenderer(Renderer render) : render_(std::move(render)), thread_([this] { Loop(); }) {}

UnitRenderer::~UnitRenderer() {
    {
        const std::lock_guard lock(mutex_);
        observer_.stops = true;
    }
    changed_.notify_all();
    thread_.join();
}

void UnitRenderer::Put(const RenderUnit& unit) {
    {
        const std::lock_guard lock(mutex_);
        todo_.push_back(unit);
    }
    changed_.notify_all();
}

std::optional<RenderedUnit> UnitRenderer::TryTake() {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
    if (done_.empty()) return {};
    RenderedUnit unit = std::move(done_.front());
    done_.pop_front();
    return unit;
}

void UnitRenderer::Wait(double seconds) {
    std::unique_lock lock(mutex_);
    finished_.wait_for(lock, std::chrono::duration<double>(seconds),
                       [this] { return !done_.empty() || error_; });
}

void UnitRenderer::Loop() {
    for (;;) {
        RenderUnit unit;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return observer_.stops || !todo_.empty(); });
            if (observer_.stops) return;
            unit = todo_.front();
            todo_.pop_front();
        }
        try {
            RenderedUnit rendered = render_(unit, observer_);
            const std::lock_guard lock(mutex_);
            if (observer_.stops) return;
            done_.push_back(std::move(rendered));
        } catch (...) {
            const std::lock_guard lock(mutex_);
            error_ = std::current_exception();
        }
        finished_.notify_all();
    }
}

}  // namespace lacquer::cmd
