// Light path expressions as text, read into the positions of an automaton [Glushkov 1961].
#pragma once

#include <bitset>
#include <string>
#include <vector>

#include "pbrt/film/light_path_automaton.h"

namespace lacquer {

/// Sets of what an expression's elements stand for: PathEvent first, then for each light group the sources.
using PathSymbols = std::bitset<kNumPathEvents + kNumPathSources*(kMaxLightGroups + 1)>;
inline size_t SymbolOf(PathSource source, size_t group) {
    return kNumPathEvents + group * kNumPathSources + size_t(source);
}

/// Places of all expressions together where an event or a source stands. A path is at several at once; it
/// goes on to those that follow and have its next event.
struct PathPositions {
    struct Position {
        PathSymbols symbols;
        std::vector<int> followers;
        int expression = 0;
        bool isLast = false;  ///< a path may end here
    };
    std::vector<Position> positions;

    /// Adds an expression. @return  its start, a position without symbols
    /// @param groups  null: any name of a light group is right
    /// Errors: LightPathError.
    int Add(const std::string& text, int expression, const std::vector<std::string>* groups);
};

}  // namespace lacquer
