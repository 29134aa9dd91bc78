#include "pbrt/film/splats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pbrt/base/film.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer {

namespace {
constexpr size_t kBytesOfPixel = 51;
}  // namespace

void SplatSums::Prepare(const Bounds2i& bounds, int threads) {
    if (int(threads_.size()) >= threads) return;
    const size_t bytes = size_t(bounds.Area()) * kBytesOfPixel * size_t(threads);
    if (bytes > kMaxBytes)
        throw OverrideError(fmt::format(
            "tracing light from the lights with {} threads to {} x {} pixels takes {:.1f} GiB, but "
            "at most {} are allowed; render with fewer threads or in crop windows",
            threads, bounds.Width(), bounds.Height(), double(bytes) / double(1 << 30), kMaxBytes >> 30));
    bounds_ = bounds;
    threads_.resize(size_t(threads));
}

void SplatSums::Add(Point2 p, Vec3 value, const Filter& filter) {
    const int thread = ThreadIndex();
    LACQUER_CHECK(thread < int(threads_.size()));
    ExactSums& pixels = threads_[size_t(thread)].pixels;
    if (pixels.Size() == 0) pixels = ExactSums(3 * size_t(bounds_.Area()));

    // The pixels whose centres lie within the radius.
    const Vec2 radius = filter.Radius(), onCentres = p - Vec2(0.5f);
    const Int2 first = glm::max(Int2(glm::ceil(onCentres - radius)), bounds_.min);
    const Int2 last = glm::min(Int2(glm::floor(onCentres + radius)), bounds_.max - 1);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            const double weight = double(filter.Evaluate(onCentres - Vec2(float(x), float(y))));
            if (weight == 0) continue;
            const size_t pixel =
                size_t(y - bounds_.min.y) * size_t(bounds_.Width()) + size_t(x - bounds_.min.x);
            for (int c = 0; c < 3; ++c) pixels.Add(3 * pixel + size_t(c), weight * double(value[c]));
        }
}

glm::dvec3 SplatSums::Sum(size_t i) const {
    ExactSums sum(3);
    for (const Sums& thread : threads_)
        for (size_t c = 0; c < 3 && thread.pixels.Size() > 0; ++c) sum.Add(c, thread.pixels, 3 * i + c);
    return {sum[0], sum[1], sum[2]};
}

ExactSums& SplatSums::Gathered() {
    ExactSums& first = threads_[0].pixels;
    if (first.Size() == 0) first = ExactSums(3 * size_t(bounds_.Area()));
    for (size_t i = 1; i < threads_.size(); ++i) {
        if (threads_[i].pixels.Size() > 0) first.Add(threads_[i].pixels);
        threads_[i].pixels = ExactSums();
    }
    return first;
}

size_t SplatSums::Bytes() const {
    size_t bytes = 0;
    for (const Sums& thread : threads_) bytes += thread.pixels.Bytes();
    return bytes;
}

}  // namespace lacquer
