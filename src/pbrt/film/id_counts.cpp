#include "pbrt/film/id_counts.h"

#include <algorithm>

namespace lacquer {

namespace {

/// Counts `id` in its entry or a free one; false if all are taken by others.
template <size_t n>
bool AddTo(std::array<IdCount, n>* entries, int id) {
    for (IdCount& entry : *entries) {
        if (entry.count == 0) entry.id = id;
        if (entry.id != id) continue;
        ++entry.count;
        return true;
    }
    return false;
}

}  // namespace

void IdCounts::Add(size_t index, int id) {
    Pixel& pixel = pixels_[index];
    if (AddTo(&pixel.first, id)) return;
    if (!pixel.more) pixel.more = std::make_unique<std::array<IdCount, kMax - kInline>>();
    AddTo(pixel.more.get(), id);
}

std::vector<IdCount> IdCounts::Ranked(size_t index) const {
    const Pixel& pixel = pixels_[index];
    std::vector<IdCount> ranked(pixel.first.begin(), pixel.first.end());
    if (pixel.more) ranked.insert(ranked.end(), pixel.more->begin(), pixel.more->end());
    std::erase_if(ranked, [](const IdCount& entry) { return entry.count == 0; });
    std::sort(ranked.begin(), ranked.end(), [](const IdCount& a, const IdCount& b) {
        return a.count != b.count ? a.count > b.count : a.id < b.id;
    });
    return ranked;
}

}  // namespace lacquer
