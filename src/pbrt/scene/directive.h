// The directives of scene files, in one table: what follows each, where it may stand, what it does. The
// parser, the formatter of `lacquer convert`, the upgrade from pbrt-v3 and the messages go by it. A new
// directive is one row in directives.cpp, with the function that it runs.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/parameter.h"
#include "pbrt/scene/lexer.h"

namespace lacquer {

class FileParser;

/// An argument of a directive.
enum class Argument : unsigned char {
    None,
    // One string in quotes.
    Name,
    NewMaterial,  ///< the name that it gets; counts as defined though the rest may be wrong
    NewMedium,    ///< likewise
    Type,         ///< of the plugin that the directive makes
    ValueType,    ///< of a texture
    Target,       ///< of an Attribute
    Medium,
    OtherMedium,  ///< may be left out: then it is the argument before it
    File,         ///< a scene file, which is read in this place
    // One other token.
    Times,  ///< All, StartTime or EndTime
    Value,  ///< a word or a string
    // Numbers.
    Number,
    Vector,  ///< three
    Matrix,  ///< sixteen, in brackets
    // Any number of "type name" values.
    Parameters,
};

/// How an argument is written.
struct ArgumentForm {
    const char* wanted;        ///< in messages: "a name"
    size_t numTokens = 1;      ///< 0 for Parameters
    bool isString = false;     ///< in quotes
    bool isNumber = false;     ///< its tokens are numbers, but for brackets
    bool isOptional = false;   ///< left out where no string follows
    bool isBracketed = false;  ///< the first and the last token are brackets
};
const ArgumentForm& FormOf(Argument argument);
/// Checks token `i` of an argument. @return  its value, if it is a number. Errors: SceneError at the token.
float CheckToken(std::string_view directive, Argument argument, size_t i, const Token& token);
/// Errors: SceneError at `loc`, where the text has ended before token `i`.
[[noreturn]] void FailAtEnd(std::string_view directive, Argument argument, size_t i, const FileLoc& loc);

/// Arguments that have been read.
struct DirectiveArguments {
    std::array<std::string, 3> texts;  ///< of strings and words, in their order
    std::array<float, 16> numbers;     ///< column by column, if they are a matrix
    Token value;                       ///< of Argument::Value
    std::vector<Parameter> parameters;
};

/// A row of the table.
struct Directive {
    enum class Where { Options, World, Anywhere };
    enum class Scope { None, Opens, Closes };

    std::string_view name;
    Where where;
    std::array<Argument, 4> arguments;
    void (*run)(FileParser&, DirectiveArguments&);  ///< null: of pbrt-v3, not understood
    Scope scope = Scope::None;                      ///< what stands in one is indented
    const char* plugin = nullptr;     ///< the kind of thing that it makes, where that is not its own name
    const char* advice = nullptr;     ///< of pbrt-v3 only: completes "in pbrt-v4 ..."
    const char* successor = nullptr;  ///< the name that pbrt-v4 prefers

    bool Has(Argument argument) const;
    /// "Material" for MakeNamedMaterial; empty for directives that make no plugin.
    std::string_view Plugin() const;
};

/// In alphabetical order.
std::span<const Directive> Directives();
/// The directive of that name, those of pbrt-v3 included; null if there is none.
const Directive* FindDirective(std::string_view name);
/// Names of those that pbrt-v4 has, for messages.
std::vector<std::string> DirectiveNames();

}  // namespace lacquer
