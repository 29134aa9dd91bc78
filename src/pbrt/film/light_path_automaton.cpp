#include "pbrt/film/light_path_automaton.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "pbrt/film/light_path_expression.h"

namespace lacquer {

namespace {

constexpr size_t kMaxStates = 4096;
/// Where a path can be in all expressions; in order.
using Places = std::vector<int>;

Places PlacesAfter(const PathPositions& all, const Places& places, PathEvent event) {
    Places after;
    for (const int i : places)
        for (const int j : all.positions[size_t(i)].followers)
            if (all.positions[size_t(j)].symbols.test(size_t(event))) after.push_back(j);
    std::sort(after.begin(), after.end());
    after.erase(std::unique(after.begin(), after.end()), after.end());
    return after;
}

/// Expressions that a path at these places matches if it ends at a source.
uint64_t PassesAt(const PathPositions& all, const Places& places, size_t symbol) {
    uint64_t passes = 0;
    for (const int i : places)
        for (const int j : all.positions[size_t(i)].followers) {
            const PathPositions::Position& end = all.positions[size_t(j)];
            if (end.isLast && end.symbols.test(symbol)) passes |= uint64_t(1) << end.expression;
        }
    return passes;
}

}  // namespace

LightPathAutomaton::LightPathAutomaton(const std::vector<std::string>& expressions,
                                       const std::vector<std::string>& groups)
    : numPasses_(expressions.size()), numGroups_(groups.size()) {
    if (numPasses_ > kMaxPasses)
        throw LightPathError(
            fmt::format("{} passes are too many; at most {} are possible", numPasses_, kMaxPasses));
    PathPositions all;
    Places start;
    for (const std::string& expression : expressions)
        start.push_back(all.Add(expression, int(start.size()), &groups));

    // Subset construction, along what happens on the way; sources only end paths.
    std::map<Places, State> known{{start, kStart}};
    std::vector<Places> states{start};
    uint64_t matched = 0;
    for (size_t state = 0; state < states.size(); ++state) {
        for (int event = 0; event < kNumPathEvents; ++event) {
            const auto [it, isNew] =
                known.emplace(PlacesAfter(all, states[state], PathEvent(event)), State(states.size()));
            if (isNew) states.push_back(it->first);
            next_.push_back(it->second);
        }
        if (states.size() > kMaxStates)
            throw LightPathError(fmt::format(
                "the light path expressions together need more than {} states; ask for fewer at once",
                kMaxStates));
        for (size_t group = 0; group < numGroups_; ++group)
            for (int source = 0; source < kNumPathSources; ++source) {
                passes_.push_back(PassesAt(all, states[state], SymbolOf(PathSource(source), group)));
                matched |= passes_.back();
            }
    }
    for (size_t i = 0; i < numPasses_; ++i)
        if (!(matched >> i & 1))
            throw LightPathError(fmt::format(
                "light path expression {} matches no path: light comes in by L, B or O at its end",
                expressions[i]));
}

void CheckLightPathExpression(const std::string& expression) {
    PathPositions all;
    all.Add(expression, 0, nullptr);
}

}  // namespace lacquer
