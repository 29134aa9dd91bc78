// Images of a few floats a pixel, for loops.
#pragma once

#include <array>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::denoise {

/// N floats for each pixel, rows from the top.
template <size_t N>
class Planes {
  public:
    using Value = std::array<float, N>;
    Planes() = default;
    explicit Planes(Int2 size) : size_(size), values_(size_t(size.x) * size_t(size.y), Value{}) {}
    Int2 Size() const { return size_; }
    bool IsEmpty() const { return values_.empty(); }
    const Value& At(int x, int y) const { return values_[size_t(y) * size_t(size_.x) + size_t(x)]; }
    Value& At(int x, int y) { return values_[size_t(y) * size_t(size_.x) + size_t(x)]; }
    /// With coordinates outside moved to the nearest pixel.
    const Value& Clamped(int x, int y) const {
        return At(std::clamp(x, 0, size_.x - 1), std::clamp(y, 0, size_.y - 1));
    }
    std::vector<Value>& All() { return values_; }
    const std::vector<Value>& All() const { return values_; }

  private:
    Int2 size_{0};
    std::vector<Value> values_;
};

using Color = Planes<3>;
inline constexpr int kNumFeatures = 7;  ///< albedo, normal, depth
using Features = Planes<kNumFeatures>;

/// The mean of a square of (2 radius + 1)^2 pixels, as far as it lies in the image.
template <size_t N>
Planes<N> BoxMean(const Planes<N>& planes, int radius) {
    const Int2 size = planes.Size();
    const auto along = [&](const Planes<N>& from, Int2 step) {
        Planes<N> to(size);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                typename Planes<N>::Value sum{};
                int count = 0;
                for (int i = -radius; i <= radius; ++i) {
                    const Int2 q = Int2(x, y) + i * step;
                    if (q.x < 0 || q.y < 0 || q.x >= size.x || q.y >= size.y) continue;
                    for (size_t c = 0; c < N; ++c) sum[c] += from.At(q.x, q.y)[c];
                    ++count;
                }
                for (size_t c = 0; c < N; ++c) to.At(x, y)[c] = sum[c] / float(count);
            }
        return to;
    };
    return along(along(planes, {1, 0}), {0, 1});
}

}  // namespace lacquer::denoise
