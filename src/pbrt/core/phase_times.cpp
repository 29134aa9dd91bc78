#include "pbrt/core/phase_times.h"

#include <algorithm>
#include <ctime>

namespace lacquer {

namespace {

double ProcessorSeconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace

void PhaseClock::Begin() {
    start_ = Clock::now();
    processorStart_ = ProcessorSeconds();
}

void PhaseClock::End(const std::string& phase) {
    const double seconds = SecondsSince(start_);
    const double work = ProcessorSeconds() - processorStart_;
    auto known =
        std::find_if(times_.begin(), times_.end(), [&](const PhaseTime& t) { return t.phase == phase; });
    if (known == times_.end()) known = times_.insert(known, PhaseTime{phase});
    const double together = known->seconds + seconds;
    known->processors = together > 0 ? (known->processors * known->seconds + work) / together : 0;
    known->seconds = together;
    Begin();
}

}  // namespace lacquer
