// A console with a limit of time.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "cmd/console.h"

namespace lacquer::cmd {

/// A console whose work also ends when the time does.
class TimedConsole final : public Observer {
  public:
    TimedConsole(Console* console, std::optional<double> seconds) : console_(console) {
        if (seconds)
            end_ = Clock::now() +
                   std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
    }
    void Begin(const std::string& name, int64_t total, const std::string& unit) override {
        console_->Begin(name, total, unit);
    }
    void Advance(int64_t units) override { console_->Advance(units); }
    void End() override { console_->End(); }
    void Warn(const std::string& message) override { console_->Warn(message); }
    bool ShouldStop() override { return console_->ShouldStop() || IsOver(); }
    bool IsOver() const { return end_ && Clock::now() >= *end_; }

  private:
    using Clock = std::chrono::steady_clock;
    Console* console_;
    std::optional<Clock::time_point> end_;
};

}  // namespace lacquer::cmd
