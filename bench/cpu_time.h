// The clock of the benchmarks of single evaluations.
#pragma once

#include <ctime>

namespace lacquer::bench {

/// CPU time of the calling thread [s]: what other programs do on the machine does not count, but for what
/// they take from its caches.
inline double CpuSeconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

}  // namespace lacquer::bench
