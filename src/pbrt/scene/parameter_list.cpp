#include "pbrt/scene/parameter_list.h"

#include <fmt/format.h>

#include <algorithm>

#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

using Values = Parameter::Values;

struct Type {
    const char* name;
    Values values;
};
constexpr Type kTypes[] = {
    {"float", Values::Floats},    {"integer", Values::Integers}, {"bool", Values::Bools},
    {"string", Values::Strings},  {"texture", Values::Strings},  {"point2", Values::Floats},
    {"vector2", Values::Floats},  {"point3", Values::Floats},    {"vector3", Values::Floats},
    {"normal", Values::Floats},   {"rgb", Values::Floats},       {"blackbody", Values::Floats},
    {"spectrum", Values::Floats},
};

const Type* FindType(std::string_view name) {
    const auto* found =
        std::find_if(std::begin(kTypes), std::end(kTypes), [&](const Type& t) { return name == t.name; });
    return found == std::end(kTypes) ? nullptr : found;
}

const char* Describe(Values kind) {
    switch (kind) {
        case Values::Floats:
            return "a number";
        case Values::Integers:
            return "an integer";
        case Values::Strings:
            return "a string in quotes";
        case Values::Bools:
            return "true or false";
    }
    return "";
}

bool IsBool(const Token& token) {
    return token.kind == Token::Kind::Word && (token.text == "true" || token.text == "false");
}

[[noreturn]] void Unexpected(const Token& token, const char* wanted) {
    throw SceneError(token.Loc(), fmt::format("expected {}, found {}", wanted, token.Excerpt()));
}

Values KindOfFirst(const Token& token, bool isInteger) {
    if (token.kind == Token::Kind::String) return Values::Strings;
    if (IsBool(token)) return Values::Bools;
    return isInteger ? Values::Integers : Values::Floats;
}

void Append(const Token& token, Parameter* p) {
    switch (p->kind) {
        case Values::Floats:
            p->floats.push_back(ExpectFloat(token));
            return;
        case Values::Integers:
            p->integers.push_back(ExpectInteger(token));
            return;
        case Values::Strings:
            if (token.kind != Token::Kind::String) Unexpected(token, Describe(p->kind));
            p->strings.emplace_back(token.text);
            return;
        case Values::Bools:
            if (!IsBool(token)) Unexpected(token, Describe(p->kind));
            p->bools.push_back(token.text == "true");
            return;
    }
}

// Reads one value or a list in brackets. The first value decides on their kind.
void ReadValues(Lexer& lexer, bool isInteger, Parameter* p) {
    Token token = lexer.Next();
    if (token.kind == Token::Kind::End)
        throw SceneError(p->loc, "the file ends before the parameter's value");
    if (token.kind != Token::Kind::Open) {
        if (token.kind != Token::Kind::Word && token.kind != Token::Kind::String)
            Unexpected(token, "a value");
        p->kind = KindOfFirst(token, isInteger);
        Append(token, p);
        return;
    }
    const FileLoc open = token.Loc();
    token = lexer.Next();
    p->kind = KindOfFirst(token, isInteger);
    for (; token.kind != Token::Kind::Close; token = lexer.Next()) {
        if (token.kind == Token::Kind::End)
            throw SceneError(open, "the list of values is never closed: the file ends before its ]");
        Append(token, p);
    }
}

std::string Quoted(const Parameter& p) { return fmt::format("\"{} {}\"", Excerpt(p.type), Excerpt(p.name)); }

bool IsEmpty(const Parameter& p) {
    return p.floats.empty() && p.integers.empty() && p.strings.empty() && p.bools.empty();
}

// Splits "type name" into its two words; false, with an error in the log, if there are not two.
bool SplitDeclaration(const Token& token, Parameter* p, ParseLog& log) {
    std::vector<std::string_view> words;
    std::string_view rest = token.text;
    while (true) {
        const size_t start = rest.find_first_not_of(" \t");
        if (start == std::string_view::npos) break;
        rest.remove_prefix(start);
        words.push_back(rest.substr(0, rest.find_first_of(" \t")));
        rest.remove_prefix(words.back().size());
    }
    if (words.size() == 2) {
        p->type = words[0];
        p->name = words[1];
        return true;
    }
    const char* problem = words.empty()       ? "is blank"
                          : words.size() == 1 ? "has one word"
                                              : "has more than two words";
    log.Error(p->loc, fmt::format("the parameter declaration {} {}; expected \"type name\"", token.Excerpt(),
                                  problem));
    return false;
}

// Says what is wrong with a declared type; null if it is unknown.
const Type* CheckType(const Parameter& p, ParseLog& log) {
    const Type* type = FindType(p.type);
    if (type) return type;
    if (const auto advice = V3ParameterType(p.type)) {
        log.V3(p.loc, fmt::format("the parameter type \"{}\"", p.type), *advice);
        return nullptr;
    }
    std::vector<std::string> names;
    for (const Type& t : kTypes) names.emplace_back(t.name);
    log.Error(p.loc, fmt::format("unknown parameter type \"{}\" in {}{}", Excerpt(p.type), Quoted(p),
                                 DidYouMean(p.type, names)));
    return nullptr;
}

void CheckKind(const Type& type, const Parameter& p, ParseLog& log) {
    const bool isSpectrumName = p.type == "spectrum" && p.kind == Values::Strings;
    const bool isNumeric = type.values == Values::Floats || type.values == Values::Integers;
    if (IsEmpty(p)) {
        if (isNumeric) log.Error(p.loc, fmt::format("{} has no values", Quoted(p)));
    } else if (type.values == Values::Bools && p.kind == Values::Strings &&
               (p.strings[0] == "true" || p.strings[0] == "false")) {
        log.V3(p.loc, fmt::format("\"{}\" in quotes as the value of {}", p.strings[0], Quoted(p)),
               "true and false stand without quotes");
    } else if (p.kind != type.values && !isSpectrumName) {
        log.Error(p.loc, fmt::format("the value of {} must be {}, not {}", Quoted(p), Describe(type.values),
                                     Describe(p.kind)));
    } else if (p.type == "spectrum" && p.floats.size() == 2) {
        log.Warn(p.loc, fmt::format("{} has one sample: it is zero at all other wavelengths", Quoted(p)));
    }
}

}  // namespace

float ExpectFloat(const Token& token) {
    float value = 0;
    if (token.kind != Token::Kind::Word) Unexpected(token, "a number");
    const NumberProblem problem = ParseFloat(token.text, &value);
    if (problem == NumberProblem::Malformed) Unexpected(token, "a number");
    if (problem == NumberProblem::TooLarge)
        throw SceneError(token.Loc(), fmt::format("{} is too large for a 32-bit float", token.Excerpt()));
    return value;
}

int ExpectInteger(const Token& token) {
    int value = 0;
    if (token.kind != Token::Kind::Word) Unexpected(token, "an integer");
    const NumberProblem problem = ParseInteger(token.text, &value);
    if (problem == NumberProblem::Malformed) Unexpected(token, "an integer");
    if (problem == NumberProblem::TooLarge)
        throw SceneError(token.Loc(), fmt::format("{} is too large for a 32-bit integer", token.Excerpt()));
    return value;
}

std::vector<Parameter> ReadParameters(Lexer& lexer, const ColorSpace* colorSpace, ParseLog& log) {
    std::vector<Parameter> parameters;
    while (lexer.Peek().kind == Token::Kind::String) {
        const Token declaration = lexer.Next();
        Parameter p;
        p.loc = declaration.Loc();
        p.colorSpace = colorSpace;
        const bool isDeclared = SplitDeclaration(declaration, &p, log);
        const Type* type = isDeclared ? CheckType(p, log) : nullptr;
        try {
            ReadValues(lexer, type && type->values == Values::Integers, &p);
        } catch (const SceneError& e) {
            if (!isDeclared) throw;
            throw SceneError(e.Loc(), fmt::format("{}: {}", Quoted(p), e.Message()));
        }
        if (!type) continue;
        CheckKind(*type, p, log);
        if (IsEmpty(p)) p.kind = type->values;
        parameters.push_back(std::move(p));
    }
    return parameters;
}

}  // namespace lacquer
