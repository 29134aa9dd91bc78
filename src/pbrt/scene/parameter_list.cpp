#include "pbrt/scene/parameter_list.h"

#include <fmt/format.h>

#include <algorithm>

#include "pbrt/scene/v3.h"

namespace lacquer {

namespace {

using Values = Parameter::Values;

bool IsBool(std::string_view word) { return word == "true" || word == "false"; }

[[noreturn]] void Unexpected(const Token& token, const char* wanted) {
    throw SceneError(token.Loc(), fmt::format("expected {}, found {}", wanted, token.Excerpt()));
}

Values KindOfFirst(const Token& token, bool isInteger) {
    if (token.kind == Token::Kind::String) return Values::Strings;
    if (token.kind == Token::Kind::Word && IsBool(token.text)) return Values::Bools;
    return isInteger ? Values::Integers : Values::Floats;
}

void Check(NumberProblem problem, const Token& token, Values kind) {
    if (problem == NumberProblem::Malformed) Unexpected(token, InWords(kind).one);
    if (problem == NumberProblem::TooLarge)
        throw SceneError(token.Loc(), fmt::format("{} is too large for a 32-bit {}", token.Excerpt(),
                                                  kind == Values::Floats ? "float" : "integer"));
}

void Append(const Token& token, Parameter* p) {
    const auto wanted = p->kind == Values::Strings ? Token::Kind::String : Token::Kind::Word;
    Check(token.kind == wanted ? AppendValue(token.text, p) : NumberProblem::Malformed, token, p->kind);
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

// Splits "type name" into its two words; false, with an error in the log, if there are not two.
bool ReadDeclaration(const Token& token, Parameter* p, ParseLog& log) {
    const std::vector<std::string_view> words = SplitAtBlanks(token.text);
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
const ParameterType* CheckType(const Parameter& p, ParseLog& log) {
    const ParameterType* type = FindParameterType(p.type);
    if (type) return type;
    if (const auto advice = V3ParameterType(p.type)) {
        log.V3(p.loc, fmt::format("the parameter type \"{}\"", p.type), *advice);
        return nullptr;
    }
    log.Error(p.loc, fmt::format("unknown parameter type \"{}\" in {}{}", Excerpt(p.type), p.Quoted(),
                                 NearestParameterType(p.type)));
    return nullptr;
}

void CheckKind(const ParameterType& type, const Parameter& p, ParseLog& log) {
    const bool isNamed = type.mayBeNamed && p.kind == Values::Strings;
    const bool isNumeric = type.values == Values::Floats || type.values == Values::Integers;
    if (p.NumValues() == 0) {
        if (isNumeric) log.Error(p.loc, fmt::format("{} has no values", p.Quoted()));
    } else if (type.values == Values::Bools && p.kind == Values::Strings &&
               (p.strings[0] == "true" || p.strings[0] == "false")) {
        log.V3(p.loc, fmt::format("\"{}\" in quotes as the value of {}", p.strings[0], p.Quoted()),
               "true and false stand without quotes");
    } else if (p.kind != type.values && !isNamed) {
        log.Error(p.loc, fmt::format("the value of {} must be {}, not {}", p.Quoted(),
                                     InWords(type.values).one, InWords(p.kind).one));
    } else if (p.type == "spectrum" && p.floats.size() == 2) {
        log.Warn(p.loc, fmt::format("{} has one sample: it is zero at all other wavelengths", p.Quoted()));
    }
}

}  // namespace

std::vector<std::string_view> SplitAtBlanks(std::string_view text) {
    std::vector<std::string_view> words;
    while (true) {
        const size_t start = text.find_first_not_of(" \t");
        if (start == std::string_view::npos) return words;
        text.remove_prefix(start);
        words.push_back(text.substr(0, text.find_first_of(" \t")));
        text.remove_prefix(words.back().size());
    }
}

NumberProblem AppendValue(std::string_view word, Parameter* p) {
    NumberProblem problem = NumberProblem::None;
    if (p->kind == Values::Floats) {
        problem = ParseFloat(word, &p->floats.emplace_back());
    } else if (p->kind == Values::Integers) {
        problem = ParseInteger(word, &p->integers.emplace_back());
    } else if (p->kind == Values::Bools) {
        p->bools.push_back(word == "true");
        if (!IsBool(word)) problem = NumberProblem::Malformed;
    } else {
        p->strings.emplace_back(word);
    }
    return problem;
}

float ExpectFloat(const Token& token) {
    float value = 0;
    const bool isWord = token.kind == Token::Kind::Word;
    Check(isWord ? ParseFloat(token.text, &value) : NumberProblem::Malformed, token, Values::Floats);
    return value;
}

int ExpectInteger(const Token& token) {
    int value = 0;
    const bool isWord = token.kind == Token::Kind::Word;
    Check(isWord ? ParseInteger(token.text, &value) : NumberProblem::Malformed, token, Values::Integers);
    return value;
}

std::vector<Parameter> ReadParameters(Lexer& lexer, const ColorSpace* colorSpace, ParseLog& log) {
    std::vector<Parameter> parameters;
    while (lexer.Peek().kind == Token::Kind::String) {
        const Token declaration = lexer.Next();
        Parameter p;
        p.loc = declaration.Loc();
        p.colorSpace = colorSpace;
        const bool isDeclared = ReadDeclaration(declaration, &p, log);
        const ParameterType* type = isDeclared ? CheckType(p, log) : nullptr;
        try {
            ReadValues(lexer, type && type->values == Values::Integers, &p);
        } catch (const SceneError& e) {
            if (!isDeclared) throw;
            throw SceneError(e.Loc(), fmt::format("{}: {}", p.Quoted(), e.Message()));
        }
        if (!type) continue;
        CheckKind(*type, p, log);
        if (p.NumValues() == 0) p.kind = type->values;
        parameters.push_back(std::move(p));
    }
    return parameters;
}

}  // namespace lacquer
