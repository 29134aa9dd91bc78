// Sums over windows of an image.
#pragma once

#include <algorithm>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Calls f(pixel, number) for all pixels of an image, rows from the top.
template <class Function>
void ForAllPixels(Int2 size, const Function& f) {
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) f(Int2(x, y), size_t(y) * size_t(size.x) + size_t(x));
}

/// Sums over windows around all pixels, whose side doubles. Every sum is one of fewer terms, and never a
/// difference, so that one huge value costs no other window its digits. MeanOfOthers() takes one value away.
class WindowSums {
  public:
    static constexpr int kLargest = 64;

    explicit WindowSums(Int2 size)
        : width_(size_t(size.x + kLargest)),
          height_(size_t(size.y + kLargest)),
          size_(size),
          sums_(width_ * height_) {}

    void Set(Int2 p, double value) { sums_[At(p, 0)] = value; }
    void GrowTo(int window) {
        while (window_ < window) Double();
    }

    /// Over the window around `p`, as far as it lies in the image.
    double Mean(Int2 p) const { return Sum(p) / Count(p); }
    /// The same without the pixel itself, which has `value`.
    double MeanOfOthers(Int2 p, double value) const {
        return std::max(0.0, Sum(p) - value) / std::max(1.0, Count(p) - 1);
    }

  private:
    /// From windows of w x w pixels to 2 w x 2 w. Each is kept where it begins: there, and to the right and
    /// below, nothing has changed when its turn comes.
    void Double() {
        const auto w = size_t(window_);
        for (size_t y = 0; y < height_; ++y)
            for (size_t x = 0; x < width_; ++x) {
                double& sum = sums_[y * width_ + x];
                const bool right = x + w < width_, below = y + w < height_;
                if (right) sum += sums_[y * width_ + x + w];
                if (below) sum += sums_[(y + w) * width_ + x];
                if (right && below) sum += sums_[(y + w) * width_ + x + w];
            }
        window_ *= 2;
    }
    size_t At(Int2 p, int before) const {
        constexpr int kMargin = kLargest / 2;
        return size_t(p.y + kMargin - before) * width_ + size_t(p.x + kMargin - before);
    }
    double Sum(Int2 p) const { return sums_[At(p, window_ / 2)]; }
    double Count(Int2 p) const { return double(Extent(p.x, size_.x)) * double(Extent(p.y, size_.y)); }
    int Extent(int x, int size) const {
        const int begin = x - window_ / 2;
        return std::min(begin + window_, size) - std::max(begin, 0);
    }

    size_t width_, height_;
    Int2 size_;
    std::vector<double> sums_;
    int window_ = 1;
};

}  // namespace lacquer
