// The parameters of a directive: { "type name" value }.
#pragma once

#include <vector>

#include "pbrt/core/params.h"
#include "pbrt/scene/lexer.h"
#include "pbrt/scene/parse_log.h"

namespace lacquer {

/// Reads parameters up to the first token that is no string. Declarations and kinds of values that are wrong
/// go to the log and reading goes on. Errors: SceneError for values that cannot be read to their end.
std::vector<Parameter> ReadParameters(Lexer& lexer, const ColorSpace* colorSpace, ParseLog& log);

/// The words of a text with blanks and tabs between them; of a declaration: its type and its name.
std::vector<std::string_view> SplitAtBlanks(std::string_view text);

/// Adds one value to a parameter, as it stands in a scene file: a word, or the inside of a string. The
/// parameter's `kind` says which it has to be. What is wrong is added as well.
NumberProblem AppendValue(std::string_view text, Parameter* p);

/// A number token, or a SceneError that says what was there instead.
float ExpectFloat(const Token& token);
int ExpectInteger(const Token& token);

}  // namespace lacquer
