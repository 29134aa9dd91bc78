#include "pbrt/core/phase_times.h"

#include <gtest/gtest.h>

#include <ctime>
#include <thread>

namespace lacquer::phase_times_test {
namespace {

using std::chrono::milliseconds, std::chrono::steady_clock;

void WorkFor(milliseconds duration) {
    const auto end = steady_clock::now() + duration;
    while (steady_clock::now() < end) {
    }
}

/// Of all threads of this process: those that other tests have left behind may be at work as well.
double ProcessorSeconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

TEST(PhaseClock, TellsWorkFromWaitingAndAddsUp) {
    constexpr milliseconds kTime(50);
    PhaseClock clock;
    const double start = ProcessorSeconds();
    WorkFor(kTime);
    clock.End("work");
    const double workDone = ProcessorSeconds();
    std::this_thread::sleep_for(kTime);
    clock.End("waiting");
    const double waited = ProcessorSeconds();
    WorkFor(kTime);
    clock.End("work");
    const double end = ProcessorSeconds();
    const std::vector<PhaseTime>& times = clock.Times();
    ASSERT_EQ(times.size(), 2u);
    EXPECT_EQ(times[0].phase, "work");
    EXPECT_GE(times[0].seconds, 0.1);
    EXPECT_EQ(times[1].phase, "waiting");
    EXPECT_GE(times[1].seconds, 0.05);
    // A machine with other work gives less than a processor to the work of this thread.
    const double work = workDone - start + (end - waited), waiting = waited - workDone;
    EXPECT_GT(times[0].processors, 0.02);
    EXPECT_NEAR(times[0].processors * times[0].seconds, work, 0.02);
    EXPECT_NEAR(times[1].processors * times[1].seconds, waiting, 0.02);
}

}  // namespace
}  // namespace lacquer::phase_times_test
