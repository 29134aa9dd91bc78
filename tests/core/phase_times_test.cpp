#include "pbrt/core/phase_times.h"

#include <gtest/gtest.h>

#include <thread>

namespace lacquer::phase_times_test {
namespace {

using std::chrono::milliseconds, std::chrono::steady_clock;

void WorkFor(milliseconds duration) {
    const auto end = steady_clock::now() + duration;
    while (steady_clock::now() < end) {
    }
}

TEST(PhaseClock, TellsWorkFromWaitingAndAddsUp) {
    PhaseClock clock;
    WorkFor(milliseconds(50));
    clock.End("work");
    std::this_thread::sleep_for(milliseconds(50));
    clock.End("waiting");
    WorkFor(milliseconds(50));
    clock.End("work");
    const std::vector<PhaseTime>& times = clock.Times();
    ASSERT_EQ(times.size(), 2u);
    EXPECT_EQ(times[0].phase, "work");
    EXPECT_GE(times[0].seconds, 0.1);
    EXPECT_EQ(times[1].phase, "waiting");
    EXPECT_GE(times[1].seconds, 0.05);
    // A machine with other work gives less than a processor, and never more to one thread.
    EXPECT_GT(times[0].processors, 0.02);
    EXPECT_LT(times[0].processors, 1.05);
    EXPECT_LT(times[1].processors, 0.5 * times[0].processors);
}

}  // namespace
}  // namespace lacquer::phase_times_test
