#include "pbrt/core/parameter.h"

#include <fmt/format.h>

#include <algorithm>

namespace lacquer {

namespace {

using Values = Parameter::Values;

constexpr ParameterType kTypes[] = {
    {"float", Values::Floats, 1},
    {"integer", Values::Integers, 1},
    {"bool", Values::Bools, 1},
    {"string", Values::Strings, 1},
    {"texture", Values::Strings, 1},
    {"point2", Values::Floats, 2},
    {"vector2", Values::Floats, 2},
    {"point3", Values::Floats, 3, false, "point"},
    {"vector3", Values::Floats, 3, false, "vector"},
    {"normal", Values::Floats, 3},
    {"rgb", Values::Floats, 3, false, "color"},
    {"blackbody", Values::Floats, 1},
    {"spectrum", Values::Floats, 2, true},  // pairs of wavelength and value
};

/// In the order of Parameter::Values.
constexpr ValuesInWords kInWords[] = {
    {"a number", "numbers"},
    {"an integer", "integers"},
    {"a string in quotes", "strings"},
    {"true or false", "true or false"},
};

template <class Matches>
const ParameterType* FindType(const Matches& matches) {
    const auto* found = std::find_if(std::begin(kTypes), std::end(kTypes), matches);
    return found == std::end(kTypes) ? nullptr : found;
}

}  // namespace

size_t Parameter::NumValues() const {
    switch (kind) {
        case Values::Floats:
            return floats.size();
        case Values::Integers:
            return integers.size();
        case Values::Strings:
            return strings.size();
        case Values::Bools:
            return bools.size();
    }
    return 0;
}

void Parameter::Clear() {
    floats.clear();
    integers.clear();
    strings.clear();
    bools.clear();
}

std::string Parameter::Quoted() const { return fmt::format("\"{} {}\"", Excerpt(type), Excerpt(name)); }

std::span<const ParameterType> ParameterTypes() { return kTypes; }

const ParameterType* FindParameterType(std::string_view name) {
    return FindType([&](const ParameterType& t) { return name == t.name; });
}

const ParameterType* FindV3ParameterType(std::string_view name) {
    return FindType([&](const ParameterType& t) { return t.v3 && name == t.v3; });
}

std::string NearestParameterType(std::string_view name) {
    std::vector<std::string> names;
    for (const ParameterType& type : kTypes) names.emplace_back(type.name);
    return DidYouMean(name, names);
}

const ValuesInWords& InWords(Values kind) { return kInWords[size_t(kind)]; }

}  // namespace lacquer
