// The clock by which work is timed.
#pragma once

#include <chrono>

namespace lacquer {

using Clock = std::chrono::steady_clock;
inline double SecondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace lacquer
