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

std::vector<int> IdCounts::Flat() const {
    std::vector<int> numbers;
    for (size_t i = 0; i < pixels_.size(); ++i) {
        std::vector<IdCount> ids = Ranked(i);
        std::sort(ids.begin(), ids.end(), [](const IdCount& a, const IdCount& b) { return a.id < b.id; });
        numbers.push_back(int(ids.size()));
        for (const IdCount& id : ids) numbers.insert(numbers.end(), {id.id, int(id.count)});
    }
    return numbers;
}

bool IdCounts::IsFlat(const std::vector<int>& numbers, size_t numPixels) const {
    size_t next = 0;
    for (size_t i = 0; i < numPixels; ++i) {
        if (next >= numbers.size()) return false;
        const int count = numbers[next++];
        if (count < 0 || size_t(count) > (numbers.size() - next) / 2) return false;
        for (int k = 0; k < count; ++k, next += 2)
            if (numbers[next] < 0 || numbers[next] >= numIds_ || numbers[next + 1] < 1) return false;
    }
    return next == numbers.size();
}

void IdCounts::AddFlat(const std::vector<int>& numbers, const std::vector<size_t>& pixels) {
    size_t next = 0;
    for (const size_t pixel : pixels)
        for (int left = numbers[next++]; left > 0; --left, next += 2)
            Add(pixel, numbers[next], uint32_t(numbers[next + 1]));
}

}  // namespace lacquer
