#include "pbrt/film/render_state.h"

#include <fmt/format.h>

#include "pbrt/core/check.h"

namespace lacquer {
namespace {

/// For each pixel of `part`, in rows from the top, its number among those of `whole`.
std::vector<size_t> PixelsOf(const Bounds2i& part, const Bounds2i& whole) {
    std::vector<size_t> pixels;
    pixels.reserve(size_t(part.Area()));
    for (int y = part.min.y; y < part.max.y; ++y)
        for (int x = part.min.x; x < part.max.x; ++x)
            pixels.push_back(size_t(y - whole.min.y) * size_t(whole.Width()) + size_t(x - whole.min.x));
    return pixels;
}

/// True if arrays of so many values have as many for each of their pixels.
bool HaveOneStride(size_t stored, size_t storedPixels, size_t values, size_t pixels) {
    const size_t stride = values / pixels;
    return values == stride * pixels && stored == stride * storedPixels;
}

bool Fits(const StoredArray& stored, const StateArray& to, size_t storedPixels, size_t pixels) {
    if (stored.name != to.name || stored.values.index() != to.values.index()) return false;
    if (const auto* sums = std::get_if<ExactSums>(&stored.values))
        return HaveOneStride(sums->Size(), storedPixels, std::get<ExactSums*>(to.values)->Size(), pixels);
    if (const auto* counts = std::get_if<std::vector<int>>(&stored.values))
        return HaveOneStride(counts->size(), storedPixels, std::get<std::vector<int>*>(to.values)->size(),
                             pixels);
    return std::get<IdCounts*>(to.values)->IsFlat(std::get<FlatIds>(stored.values).numbers, storedPixels);
}

/// Calls add(i, j) for all values of all pixels: number i of the stored ones and j of the others.
template <class Add>
void ForValues(size_t size, const std::vector<size_t>& pixels, const Add& add) {
    const size_t stride = size / pixels.size();
    for (size_t i = 0; i < pixels.size(); ++i)
        for (size_t k = 0; k < stride; ++k) add(i * stride + k, pixels[i] * stride + k);
}

void AddArray(const StoredArray& stored, const StateArray& to, const std::vector<size_t>& pixels) {
    if (const auto* sums = std::get_if<ExactSums>(&stored.values)) {
        ExactSums& sum = *std::get<ExactSums*>(to.values);
        ForValues(sums->Size(), pixels, [&](size_t i, size_t j) { sum.Add(j, *sums, i); });
    } else if (const auto* ids = std::get_if<FlatIds>(&stored.values)) {
        std::get<IdCounts*>(to.values)->AddFlat(ids->numbers, pixels);
    } else {
        const auto& counts = std::get<std::vector<int>>(stored.values);
        std::vector<int>& sum = *std::get<std::vector<int>*>(to.values);
        ForValues(counts.size(), pixels, [&](size_t i, size_t j) { sum[j] += counts[i]; });
    }
}

}  // namespace

std::string AddState(const std::vector<StoredArray>& stored, const std::vector<StateArray>& to,
                     const Bounds2i& part, const Bounds2i& whole) {
    LACQUER_CHECK(!part.IsEmpty() && part.Intersect(whole) == part);
    if (stored.size() != to.size())
        return fmt::format("it has {} arrays, and {} are expected", stored.size(), to.size());
    for (size_t i = 0; i < to.size(); ++i)
        if (!Fits(stored[i], to[i], size_t(part.Area()), size_t(whole.Area())))
            return fmt::format("its array \"{}\" is not the \"{}\" that is expected", stored[i].name,
                               to[i].name);
    const std::vector<size_t> pixels = PixelsOf(part, whole);
    for (size_t i = 0; i < to.size(); ++i) AddArray(stored[i], to[i], pixels);
    return {};
}

}  // namespace lacquer
