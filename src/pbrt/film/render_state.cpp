#include "pbrt/film/render_state.h"

#include <fmt/format.h>

namespace lacquer {
namespace {

bool Fits(const StoredArray& stored, const StateArray& to) {
    if (stored.name != to.name || stored.values.index() != to.values.index()) return false;
    if (const auto* sums = std::get_if<ExactSums>(&stored.values))
        return sums->Size() == std::get<ExactSums*>(to.values)->Size();
    if (const auto* counts = std::get_if<std::vector<int>>(&stored.values))
        return counts->size() == std::get<std::vector<int>*>(to.values)->size();
    return std::get<IdCounts*>(to.values)->IsFlat(std::get<FlatIds>(stored.values).numbers);
}

void AddArray(const StoredArray& stored, const StateArray& to) {
    if (const auto* sums = std::get_if<ExactSums>(&stored.values))
        return std::get<ExactSums*>(to.values)->Add(*sums);
    if (const auto* ids = std::get_if<FlatIds>(&stored.values))
        return std::get<IdCounts*>(to.values)->AddFlat(ids->numbers);
    const auto& counts = std::get<std::vector<int>>(stored.values);
    std::vector<int>& sum = *std::get<std::vector<int>*>(to.values);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += counts[i];
}

}  // namespace

std::string AddState(const std::vector<StoredArray>& stored, const std::vector<StateArray>& to) {
    if (stored.size() != to.size())
        return fmt::format("it has {} arrays, and {} are expected", stored.size(), to.size());
    for (size_t i = 0; i < to.size(); ++i)
        if (!Fits(stored[i], to[i]))
            return fmt::format("its array \"{}\" is not the \"{}\" that is expected", stored[i].name,
                               to[i].name);
    for (size_t i = 0; i < to.size(); ++i) AddArray(stored[i], to[i]);
    return {};
}

}  // namespace lacquer
