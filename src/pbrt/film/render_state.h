// What a render has added up, as named arrays: to keep it in a file, to go on from there, and to add parts.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "pbrt/core/vec.h"
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

/// Adds what was stored of the pixels `part` to arrays of the same names and kinds, all of which are there,
/// of the pixels `whole`, in which `part` lies.
/// @return  what does not fit; empty if all does. Nothing has changed then
std::string AddState(const std::vector<StoredArray>& stored, const std::vector<StateArray>& to,
                     const Bounds2i& part, const Bounds2i& whole);

}  // namespace lacquer
