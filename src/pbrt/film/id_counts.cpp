#include "pbrt/film/id_counts.h"

#include <algorithm>

namespace lacquer {

void IdCounts::Add(size_t index, int id, uint32_t count) {
    Pixel& pixel = pixels_[index];
    for (IdCount& entry : pixel.first)
        if (entry.count == 0 || entry.id == id) {
            entry = {id, entry.count + count};
            return;
        }
    if (!pixel.more) pixel.more = std::make_unique<std::vector<IdCount>>();
    const auto entry = std::find_if(pixel.more->begin(), pixel.more->end(),
                                    [&](const IdCount& other) { return other.id == id; });
    if (entry != pixel.more->end())
        entry->count += count;
    else
        pixel.more->push_back({id, count});
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
