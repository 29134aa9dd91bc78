// Stops work after a part of it, as a user would.
#pragma once

#include <atomic>

#include "pbrt/core/progress.h"

namespace lacquer::test {

/// Asks to stop once so many units are done; threads finish what they have begun.
class StoppingObserver final : public Observer {
  public:
    explicit StoppingObserver(int64_t units) : left_(units) {}
    void Advance(int64_t units) override { left_ -= units; }
    bool ShouldStop() override { return left_ <= 0; }

  private:
    std::atomic<int64_t> left_;
};

}  // namespace lacquer::test
