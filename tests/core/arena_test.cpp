#include "pbrt/core/arena.h"

#include <gtest/gtest.h>

#include <array>

namespace lacquer::arena_test {
namespace {

struct alignas(64) CacheLine {
    explicit CacheLine(int v) : value(v) {}
    int value;
};

TEST(Arena, AlignsWhatItMakes) {
    Arena arena;
    for (int i = 0; i < 5000; ++i) {
        char* c = arena.New<char>('x');
        double* d = arena.New<double>(1.5);
        CacheLine* line = arena.New<CacheLine>(i);
        EXPECT_EQ(reinterpret_cast<uintptr_t>(d) % alignof(double), 0u);
        EXPECT_EQ(reinterpret_cast<uintptr_t>(line) % 64, 0u);
        EXPECT_EQ(*c, 'x');
        EXPECT_EQ(*d, 1.5);
        EXPECT_EQ(line->value, i);
    }
}

TEST(Arena, ObjectsDoNotOverlapAcrossBlocks) {
    Arena arena;
    using Chunk = std::array<int, 1000>;
    std::vector<Chunk*> chunks;
    for (int i = 0; i < 200; ++i) {
        chunks.push_back(arena.New<Chunk>());
        chunks.back()->fill(i);
    }
    EXPECT_GT(arena.BytesReserved(), 200 * sizeof(Chunk));
    for (int i = 0; i < 200; ++i)
        for (const int v : *chunks[size_t(i)]) ASSERT_EQ(v, i);
}

TEST(Arena, ArraysAreAlignedAndStartAsZero) {
    Arena arena;
    for (int round = 0; round < 3; ++round) {
        for (size_t n = 0; n < 100; ++n) {
            arena.New<char>('x');
            const std::span<double> array = arena.NewArray<double>(n);
            ASSERT_EQ(array.size(), n);
            EXPECT_EQ(reinterpret_cast<uintptr_t>(array.data()) % alignof(double), 0u);
            for (double& value : array) {
                ASSERT_EQ(value, 0);
                value = 1;
            }
        }
        arena.Reset();
    }
    EXPECT_EQ(arena.NewArray<char>(Arena::kBlockSize / 4).size(), Arena::kBlockSize / 4);
    EXPECT_THROW(arena.NewArray<char>(Arena::kBlockSize / 4 + 1), std::length_error);
}

TEST(Arena, ReusesItsMemoryAfterReset) {
    Arena arena;
    const auto fill = [&] {
        void* first = arena.New<CacheLine>(0);
        for (int i = 0; i < 3000; ++i) arena.New<CacheLine>(i);
        return first;
    };
    void* before = fill();
    const size_t bytes = arena.BytesReserved();
    for (int i = 0; i < 10; ++i) {
        arena.Reset();
        EXPECT_EQ(fill(), before);
        EXPECT_EQ(arena.BytesReserved(), bytes);
    }
}

}  // namespace
}  // namespace lacquer::arena_test
