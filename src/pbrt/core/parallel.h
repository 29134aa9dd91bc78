// Parallel loops, over oneTBB.
#pragma once

#include <cstdint>
#include <functional>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Threads that loops inside may use. One object at a time, made by a command or a test.
class ThreadLimit {
  public:
    /// @param threads  0: as many as the machine has
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;
    int Threads() const { return threads_; }

  private:
    int threads_;
    void* control_;
};

/// Index of the calling worker, in [0, MaxThreads()).
int ThreadIndex();
int MaxThreads();
/// Threads that work at the same time: as a ThreadLimit has it, or one for each processor.
int AllowedThreads();

/// body(i) for i in [0, count), in any order. Exceptions of a body end the loop and are rethrown.
void ParallelFor(int64_t count, const std::function<void(int64_t)>& body);
/// Both, perhaps at the same time. Exceptions are rethrown.
void ParallelInvoke(const std::function<void()>& a, const std::function<void()>& b);
enum class TileOrder {
    Rows,      ///< neighbours after one another
    Scattered  ///< any first part of them is spread over the whole
};
/// body(tile) for square tiles of `size` pixels that cover `bounds`.
void ParallelTiles(const Bounds2i& bounds, int size, TileOrder order,
                   const std::function<void(const Bounds2i&)>& body);

}  // namespace lacquer
