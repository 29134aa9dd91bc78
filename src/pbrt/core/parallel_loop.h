// What parallel loops are made of: by oneTBB (parallel_tbb.cpp), or by threads of the standard library
// (parallel_std.cpp) in programs with the thread sanitizer, which sees nothing of what a library without it
// does, and would take its tasks for races.
#pragma once

#include <cstdint>
#include <functional>

namespace lacquer {

enum class Grain {
    Any,  ///< neighbours may go to one thread together
    One   ///< each step may go to another thread
};
/// body(i) for i in [0, count). Exceptions of a body end the loop and are rethrown.
void RunLoop(int64_t count, Grain grain, const std::function<void(int64_t)>& body);

}  // namespace lacquer
