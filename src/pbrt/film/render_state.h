// What a render has added up, as named arrays: to keep it in a file, to go on from there, and to add parts.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "pbrt/film/exact_sums.h"
#include "pbrt/film/id_counts.h"

namespace lacquer {

/// Sums or numbers of all pixels, as many for each: of a film or of auxiliary outputs, where they are.
struct StateArray {
    std::string name;
    std::variant<ExactSums*, std::vector<int>*, IdCounts*> values;
};
/// IdCounts::Flat().
struct FlatIds {
    std::vector<int> numbers;
};
/// The same of a file.
struct StoredArray {
    std::string name;
    std::variant<ExactSums, std::vector<int>, FlatIds> values;
};

/// Adds what was stored to arrays of the same names, kinds and sizes, all of which are there.
/// @return  what does not fit; empty if all does. Nothing has changed then
std::string AddState(const std::vector<StoredArray>& stored, const std::vector<StateArray>& to);

}  // namespace lacquer
