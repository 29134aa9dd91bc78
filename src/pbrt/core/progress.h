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
    /// @param unit  "samples": what the units are, where their rate means something; else empty
    virtual void Begin(const std::string& /*name*/, int64_t /*total*/, const std::string& /*unit*/) {}
    /// `units` more are done.
    virtual void Advance(int64_t /*units*/) {}
    virtual void End() {}
    /// Something a user wants to know that is not an error: text with its place.
    virtual void Warn(const std::string& /*message*/) {}
    /// True if the work should stop at the next good opportunity (an interrupt, a time limit).
    virtual bool ShouldStop() { return false; }
};

}  // namespace lacquer
