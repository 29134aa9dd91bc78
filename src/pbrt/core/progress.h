// What long work tells about itself; commands decide how to show it.
#pragma once

#include <cstdint>
#include <string>

namespace lacquer {

/// Receives notices from library code. Calls may come from several threads at once.
class Observer {
  public:
    virtual ~Observer() = default;
    /// Work called `name` begins; `total` units of it.
    virtual void Begin(const std::string& /*name*/, int64_t /*total*/) {}
    /// `units` more are done.
    virtual void Advance(int64_t /*units*/) {}
    virtual void End() {}
    /// Something a user wants to know that is not an error: text with its place.
    virtual void Warn(const std::string& /*message*/) {}
    /// True if the work should stop at the next good opportunity (an interrupt, a time limit).
    virtual bool ShouldStop() { return false; }
};

}  // namespace lacquer
