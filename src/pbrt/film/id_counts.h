// Which ids the samples of each pixel saw, and how often.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace lacquer {

/// An id and the number of a pixel's samples that saw it.
struct IdCount {
    int id = -1;
    uint32_t count = 0;
};

/// Counts exactly, whatever the order. Memory: 24 bytes a pixel, and where more than two ids meet 32 more, 8
/// to 16 for each id after the second, and what two allocations cost. Pixels belong to one thread at a time.
class IdCounts {
  public:
    /// @param numIds  those from 0 on
    IdCounts(size_t numPixels, int numIds) : numIds_(numIds), pixels_(numPixels) {}

    void Add(size_t pixel, int id, uint32_t count = 1);
    /// The pixel's ids, the most frequent ones first, of equal ones the smaller id first.
    std::vector<IdCount> Ranked(size_t pixel) const;

    /// Of each pixel the number of its ids, and of each id, in rising order, itself and its count.
    std::vector<int> Flat() const;
    /// True for numbers that Flat() of so many pixels can have.
    bool IsFlat(const std::vector<int>& numbers, size_t numPixels) const;
    /// @param pixels  for each of those, which of ours it is
    void AddFlat(const std::vector<int>& numbers, const std::vector<size_t>& pixels);

  private:
    static constexpr int kInline = 2;
    struct Pixel {
        std::array<IdCount, kInline> first;
        std::unique_ptr<std::vector<IdCount>> more;
    };
    int numIds_;
    std::vector<Pixel> pixels_;
};

}  // namespace lacquer
