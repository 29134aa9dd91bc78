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

/// Counts exactly, for up to kMax different ids a pixel: those that its samples meet first. Samples of
/// further ids are left out. Memory: 24 bytes a pixel, and 112 more (and what an allocation costs) where more
/// than two ids meet. Pixels belong to one thread at a time.
class IdCounts {
  public:
    static constexpr int kMax = 16;
    explicit IdCounts(size_t numPixels) : pixels_(numPixels) {}

    void Add(size_t pixel, int id);
    /// The pixel's ids, the most frequent ones first, of equal ones the smaller id first.
    std::vector<IdCount> Ranked(size_t pixel) const;

  private:
    static constexpr int kInline = 2;
    struct Pixel {
        std::array<IdCount, kInline> first;
        std::unique_ptr<std::array<IdCount, kMax - kInline>> more;
    };
    std::vector<Pixel> pixels_;
};

}  // namespace lacquer
