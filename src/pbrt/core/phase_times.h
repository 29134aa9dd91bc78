// Where the time goes before the first ray, and on how many processors.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/clock.h"

namespace lacquer {

/// A part of the work, in its own words: "shapes".
struct PhaseTime {
    std::string phase;
    double seconds = 0;     ///< of the clock
    double processors = 0;  ///< seconds of all threads of the process, over those of the clock
};

/// Measures phases that follow each other, from its construction on.
class PhaseClock {
  public:
    PhaseClock() { Begin(); }
    /// Ends a phase and begins the next one. One that has ended before goes on: its times are added up.
    void End(const std::string& phase);
    const std::vector<PhaseTime>& Times() const { return times_; }

  private:
    void Begin();

    Clock::time_point start_;
    double processorStart_ = 0;
    std::vector<PhaseTime> times_;
};

}  // namespace lacquer
