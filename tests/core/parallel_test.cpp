#include "pbrt/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <stdexcept>
#include <vector>

namespace lacquer::parallel_test {
namespace {

constexpr int kThreadCounts[] = {1, 2, 7};

TEST(Parallel, ForVisitsEveryIndexOnce) {
    for (const int threads : kThreadCounts) {
        const ThreadLimit limit(threads);
        EXPECT_EQ(limit.Threads(), threads);
        std::vector<std::atomic<int>> visits(10007);
        ParallelFor(int64_t(visits.size()), [&](int64_t i) { ++visits[size_t(i)]; });
        for (const auto& v : visits) ASSERT_EQ(v, 1);
    }
}

TEST(Parallel, InvokeDoesBothAndPassesErrorsOn) {
    for (const int threads : kThreadCounts) {
        const ThreadLimit limit(threads);
        // Within each other, as trees are built.
        std::atomic<int> calls = 0;
        const std::function<void(int)> divide = [&](int depth) {
            ++calls;
            if (depth > 0) ParallelInvoke([&] { divide(depth - 1); }, [&] { divide(depth - 1); });
        };
        divide(6);
        EXPECT_EQ(calls, 127);
        EXPECT_THROW(ParallelInvoke([] {}, [] { throw std::runtime_error("second"); }), std::runtime_error);
    }
}

TEST(Parallel, LoopsInsideOfLoopsKeepToTheirSteps) {
    // A thread that waits for an inner loop takes steps of that alone: what the outer one has begun on it is
    // not ready for another step.
    for (const int threads : kThreadCounts) {
        const ThreadLimit limit(threads);
        std::atomic<int64_t> inner = 0;
        std::vector<std::atomic<int>> busy(static_cast<size_t>(MaxThreads()));
        ParallelFor(3000, [&](int64_t) {
            const auto self = size_t(ThreadIndex());
            ASSERT_LT(self, busy.size());
            EXPECT_EQ(busy[self]++, 0);
            ParallelFor(50, [&](int64_t i) {
                EXPECT_LT(size_t(ThreadIndex()), busy.size());
                inner += i;
            });
            EXPECT_EQ(size_t(ThreadIndex()), self);
            --busy[self];
        });
        EXPECT_EQ(inner, 3000 * 49 * 50 / 2);
        EXPECT_THROW(
            ParallelFor(10,
                        [](int64_t) { ParallelFor(10, [](int64_t) { throw std::runtime_error("inner"); }); }),
            std::runtime_error);
        // And the next one is an outer loop again.
        std::atomic<int> count = 0;
        ParallelFor(1000, [&](int64_t) { ++count; });
        EXPECT_EQ(count, 1000);
    }
}

TEST(Parallel, LoopsOverNothingDoNothing) {
    ParallelFor(0, [](int64_t) { FAIL(); });
    ParallelTiles({{3, 3}, {3, 9}}, 4, TileOrder::Rows, [](const Bounds2i&) { FAIL(); });
}

TEST(Parallel, TilesCoverEveryPixelOnce) {
    for (const int threads : kThreadCounts)
        for (const auto& [bounds, order] : {std::pair(Bounds2i{{0, 0}, {64, 48}}, TileOrder::Rows),
                                            std::pair(Bounds2i{{0, 0}, {64, 48}}, TileOrder::Scattered),
                                            std::pair(Bounds2i{{-5, 3}, {60, 4}}, TileOrder::Scattered),
                                            std::pair(Bounds2i{{2, 5}, {9, 6}}, TileOrder::Scattered),
                                            std::pair(Bounds2i{{7, 7}, {8, 90}}, TileOrder::Rows)}) {
            const ThreadLimit limit(threads);
            std::vector<std::atomic<int>> visits(size_t(bounds.Area()));
            ParallelTiles(bounds, 16, order, [&, bounds = bounds](const Bounds2i& tile) {
                EXPECT_FALSE(tile.IsEmpty());
                EXPECT_LE(tile.Width(), 16);
                EXPECT_LE(tile.Height(), 16);
                for (int y = tile.min.y; y < tile.max.y; ++y)
                    for (int x = tile.min.x; x < tile.max.x; ++x) {
                        ASSERT_TRUE(bounds.Contains({x, y}));
                        ++visits[size_t(y - bounds.min.y) * size_t(bounds.Width()) +
                                 size_t(x - bounds.min.x)];
                    }
            });
            for (const auto& v : visits) ASSERT_EQ(v, 1);
        }
}

TEST(Parallel, TheFirstOfScatteredTilesAreSpreadOverAll) {
    const ThreadLimit limit(1);
    for (const auto& [order, isSpread] :
         {std::pair(TileOrder::Scattered, true), std::pair(TileOrder::Rows, false)}) {
        // 400 tiles; the first 100 of them by quarter of the area.
        int seen = 0, quarters[4] = {};
        ParallelTiles({{0, 0}, {320, 320}}, 16, order, [&](const Bounds2i& tile) {
            if (seen++ < 100) ++quarters[(tile.min.x >= 160) + 2 * (tile.min.y >= 160)];
        });
        EXPECT_EQ(seen, 400);
        for (const int count : quarters) EXPECT_EQ(count >= 20 && count <= 30, isSpread) << count;
    }
}

TEST(Parallel, WorkersHaveIndicesOfTheirOwn) {
    for (const int threads : kThreadCounts) {
        const ThreadLimit limit(threads);
        EXPECT_GE(MaxThreads(), threads);
        const size_t slots = size_t(MaxThreads());
        std::vector<std::atomic<int>> inside(slots);
        ParallelFor(2000, [&](int64_t) {
            const int index = ThreadIndex();
            ASSERT_GE(index, 0);
            ASSERT_LT(size_t(index), inside.size());
            // Nobody else may work under this index at the same time.
            EXPECT_EQ(++inside[size_t(index)], 1);
            --inside[size_t(index)];
        });
    }
}

TEST(Parallel, OneThreadMeansOne) {
    const ThreadLimit limit(1);
    std::atomic<int> running = 0;
    ParallelFor(500, [&](int64_t) {
        EXPECT_EQ(++running, 1);
        --running;
    });
}

TEST(Parallel, ExceptionsOfBodiesReachTheCaller) {
    for (const int threads : kThreadCounts) {
        const ThreadLimit limit(threads);
        const auto fail = [](int64_t i) {
            if (i == 77) throw std::runtime_error("seventy-seven");
        };
        EXPECT_THROW(ParallelFor(1000, fail), std::runtime_error);
        const auto failTile = [](const Bounds2i& tile) {
            if (tile.Contains({20, 20})) throw std::runtime_error("tile");
        };
        EXPECT_THROW(ParallelTiles({{0, 0}, {64, 64}}, 8, TileOrder::Rows, failTile), std::runtime_error);
        // And the pool works on afterwards.
        std::atomic<int> sum = 0;
        ParallelFor(10, [&](int64_t i) { sum += int(i); });
        EXPECT_EQ(sum, 45);
    }
}

}  // namespace
}  // namespace lacquer::parallel_test
