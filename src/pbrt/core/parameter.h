// One parameter of a directive, and the table of the types that parameters can have.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/color_space.h"
#include "pbrt/core/error.h"

namespace lacquer {

/// "type name" [values] as it stands in the file.
struct Parameter {
    enum class Values { Floats, Integers, Strings, Bools };

    std::string type, name;
    FileLoc loc;
    Values kind = Values::Floats;
    std::vector<float> floats;
    std::vector<int> integers;
    std::vector<std::string> strings;
    std::vector<unsigned char> bools;
    const ColorSpace* colorSpace = nullptr;  ///< the one in force where the parameter stands
    bool fromAttribute = false;              ///< inherited by an Attribute directive: may stay unused
    mutable bool lookedUp = false;

    /// Values of its kind.
    size_t NumValues() const;
    /// Removes the values of all kinds.
    void Clear();
    /// `"type name"` for messages, shortened.
    std::string Quoted() const;
};

/// A type of parameters: what its values are, and what an element of a list of them is.
struct ParameterType {
    const char* name;
    Parameter::Values values;
    size_t components;         ///< values of one element: 3 for "point3"
    bool mayBeNamed = false;   ///< one name in quotes may stand instead of the values
    const char* v3 = nullptr;  ///< what pbrt-v3 calls it, where that is another name
};

/// All types, in the order in which messages list them. The one place that knows them: reading, look-ups,
/// `lacquer compare --vary` and the upgrade from pbrt-v3 go by it.
std::span<const ParameterType> ParameterTypes();
/// Null if there is none of that name.
const ParameterType* FindParameterType(std::string_view name);
/// The type that pbrt-v3 calls `name` and pbrt-v4 does not. Null if there is none.
const ParameterType* FindV3ParameterType(std::string_view name);
/// `; did you mean "float"?`, or nothing, for a name that is no type.
std::string NearestParameterType(std::string_view name);

/// A kind of values in messages: "a number", and "numbers".
struct ValuesInWords {
    const char *one, *many;
};
const ValuesInWords& InWords(Parameter::Values kind);

}  // namespace lacquer
