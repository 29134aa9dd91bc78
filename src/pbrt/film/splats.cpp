#include "pbrt/film/splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/base/film.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer {

void SplatSums::Prepare(const Bounds2i& bounds, int threads) {
    if (int(threads_.size()) >= threads) return;
    const size_t bytes = size_t(bounds.Area()) * sizeof(Pixel) * size_t(threads);
    if (bytes > kMaxBytes)
        throw OverrideError(fmt::format(
            "tracing light from the lights with {} threads to {} x {} pixels takes {:.1f} GiB, but "
            "at most {} are allowed; render with fewer threads or in crop windows",
            threads, bounds.Width(), bounds.Height(), double(bytes) / double(1 << 30), kMaxBytes >> 30));
    bounds_ = bounds;
    threads_.resize(size_t(threads));
}

SplatSums::Fixed SplatSums::ToFixed(double x) {
    // No sum of less than 1e7 of the largest values overflows.
    constexpr double kLargest = 1e14;
    const double bounded = std::clamp(x, -kLargest, kLargest);
    const double whole = std::floor(bounded);
    const auto fraction = int64_t(std::ldexp(bounded - whole, 56));
    return (Fixed(int64_t(whole)) << 56) + fraction;
}

double SplatSums::FromFixed(Fixed x) {
    const Fixed whole = x >> 56;  // beyond 64 bits for the largest sums
    const auto fraction = int64_t(x - (whole << 56));
    return double(whole) + std::ldexp(double(fraction), -56);
}

void SplatSums::Add(Point2 p, Vec3 value, const Filter& filter) {
    const int thread = ThreadIndex();
    LACQUER_CHECK(thread < int(threads_.size()));
    std::vector<Pixel>& pixels = threads_[size_t(thread)].pixels;
    if (pixels.empty()) pixels.resize(size_t(bounds_.Area()));

    // The pixels whose centres lie within the radius.
    const Vec2 radius = filter.Radius(), onCentres = p - Vec2(0.5f);
    const Int2 first = glm::max(Int2(glm::ceil(onCentres - radius)), bounds_.min);
    const Int2 last = glm::min(Int2(glm::floor(onCentres + radius)), bounds_.max - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            const double weight = double(filter.Evaluate(onCentres - Vec2(float(x), float(y))));
            if (weight == 0) continue;
            Pixel& pixel =
                pixels[size_t(y - bounds_.min.y) * size_t(bounds_.Width()) + size_t(x - bounds_.min.x)];
            for (int c = 0; c < 3; ++c) pixel.sum[c] += ToFixed(weight * double(value[c]));
        }
}

glm::dvec3 SplatSums::Sum(size_t i) const {
    Fixed sum[3] = {0, 0, 0};
    for (const Sums& thread : threads_)
        if (!thread.pixels.empty())
            for (int c = 0; c < 3; ++c) sum[c] += thread.pixels[i].sum[c];
    return {FromFixed(sum[0]), FromFixed(sum[1]), FromFixed(sum[2])};
}

size_t SplatSums::Bytes() const {
    size_t bytes = 0;
    for (const Sums& thread : threads_) bytes += thread.pixels.size() * sizeof(Pixel);
    return bytes;
}

}  // namespace lacquer
