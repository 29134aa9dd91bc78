#include "pbrt/scene/lexer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace lacquer {

namespace {

constexpr auto kEndsWord = [] {
    std::array<bool, 256> table{};
    for (const char c : {' ', '\t', '\n', '\r', '"', '[', ']'}) table[static_cast<unsigned char>(c)] = true;
    return table;
}();

bool EndsWord(char c) { return kEndsWord[static_cast<unsigned char>(c)]; }

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// The character that a backslash and `c` stand for, or nothing.
std::optional<char> Unescape(char c) {
    switch (c) {
        case 'b':
            return '\b';
        case 'f':
            return '\f';
        case 'n':
            return '\n';
        case 'r':
            return '\r';
        case 't':
            return '\t';
        case '\\':
        case '\'':
        case '"':
            return c;
        default:
            return std::nullopt;
    }
}

std::string_view WithoutPlus(std::string_view text) {
    return text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+' ? text.substr(1) : text;
}

bool IsHex(std::string_view digits) {
    return digits.size() > 2 && digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
}

NumberProblem ParseHex(std::string_view digits, bool negative, float* value) {
    uint64_t integer = 0;
    const auto [end, error] = std::from_chars(digits.data() + 2, digits.data() + digits.size(), integer, 16);
    if (error == std::errc::result_out_of_range) return NumberProblem::TooLarge;
    if (error != std::errc() || end != digits.data() + digits.size()) return NumberProblem::Malformed;
    *value = negative ? -float(integer) : float(integer);
    return NumberProblem::None;
}

// What from_chars could not hold in a float: too small becomes 0, too large is a problem.
NumberProblem ParseExtreme(std::string_view text, float* value) {
    double wide = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), wide);
    if (error == std::errc()) {
        if (std::abs(wide) > 1) return NumberProblem::TooLarge;
        *value = float(wide);
        return NumberProblem::None;
    }
    const size_t exponent = text.find_first_of("eE");
    const bool isSmall = exponent == std::string_view::npos ? text.find_first_of("123456789") > text.find('.')
                                                            : text.substr(exponent + 1).starts_with('-');
    *value = 0;
    return isSmall ? NumberProblem::None : NumberProblem::TooLarge;
}

}  // namespace

std::string Token::Excerpt() const {
    switch (kind) {
        case Kind::End:
            return "the end of the file";
        case Kind::String:
            return fmt::format("\"{}\"", lacquer::Excerpt(text));
        default:
            return lacquer::Excerpt(text);
    }
}

void Lexer::Push(Source source) {
    auto frame = std::make_unique<Frame>();
    frame->name = source.name;
    frame->memory = std::move(source.memory);
    frame->key = std::move(source.key);
    frame->at = frame->lineStart = source.text.data();
    frame->end = frame->at + source.text.size();
    frames_.push_back(std::move(frame));
}

bool Lexer::IsOpen(const std::string& key) const {
    return std::any_of(frames_.begin(), frames_.end(), [&](const auto& frame) { return frame->key == key; });
}

void Lexer::AppendOpen(std::vector<std::string>* keys) const {
    for (const auto& frame : frames_) keys->push_back(frame->key);
}

const Token& Lexer::Peek() {
    if (!pending_) pending_ = Scan();
    return *pending_;
}

Token Lexer::Next() {
    if (!pending_) return Scan();
    const Token token = *pending_;
    pending_.reset();
    return token;
}

void Lexer::SkipBlanks(Frame& frame) const {
    const char* at = frame.at;
    for (; at != frame.end; ++at) {
        if (*at == '\n') {
            ++frame.line;
            frame.lineStart = at + 1;
        } else if (*at == '#') {
            if (comments_ == Comments::Keep) break;
            // The line feed itself is counted above.
            at = std::find(at, frame.end, '\n');
            if (at == frame.end) break;
            --at;
        } else if (*at != ' ' && *at != '\t' && *at != '\r') {
            break;
        }
    }
    frame.at = at;
}

Token Lexer::Scan() {
    finished_.clear();
    while (!frames_.empty()) {
        Frame& frame = *frames_.back();
        SkipBlanks(frame);
        Token token{Token::Kind::Word, {}, frame.name, frame.line, int(frame.at - frame.lineStart) + 1};
        last_ = token;
        if (frame.at == frame.end) {
            finished_.push_back(std::move(frames_.back()));
            frames_.pop_back();
            continue;
        }
        if (*frame.at == '"') return ScanString(frame);
        if (*frame.at == '#') return ScanComment(frame, token);
        const char* start = frame.at++;
        if (*start == '[')
            token.kind = Token::Kind::Open;
        else if (*start == ']')
            token.kind = Token::Kind::Close;
        else
            while (frame.at != frame.end && !EndsWord(*frame.at)) ++frame.at;
        token.text = {start, size_t(frame.at - start)};
        return token;
    }
    return {Token::Kind::End, {}, last_.file, last_.line, last_.column};
}

// Only met where comments are kept: SkipBlanks() takes the others.
Token Lexer::ScanComment(Frame& frame, Token token) {
    const char* start = frame.at;
    frame.at = std::find(start, frame.end, '\n');
    token.kind = Token::Kind::Comment;
    token.text = {start, size_t(frame.at - start)};
    token.text = token.text.substr(0, token.text.find_last_not_of(" \t\r") + 1);
    return token;
}

Token Lexer::ScanString(Frame& frame) {
    Token token{Token::Kind::String, {}, frame.name, frame.line, int(frame.at - frame.lineStart) + 1};
    const char* start = ++frame.at;
    bool hasEscapes = false;
    std::optional<char> badEscape;
    while (frame.at != frame.end && *frame.at != '"' && *frame.at != '\n') {
        if (*frame.at == '\\' && frame.at + 1 != frame.end && frame.at[1] != '\n') {
            hasEscapes = true;
            if (!Unescape(frame.at[1]) && !badEscape) badEscape = frame.at[1];
            ++frame.at;
        }
        ++frame.at;
    }
    token.text = {start, size_t(frame.at - start)};
    if (frame.at == frame.end || *frame.at == '\n')
        throw SceneError(token.Loc(),
                         fmt::format("unterminated string: the {} comes before the closing quote of {}",
                                     frame.at == frame.end ? "file's end" : "line's end", token.Excerpt()));
    ++frame.at;
    if (badEscape)
        throw SceneError(token.Loc(),
                         fmt::format("unknown escape \\{} in {}; known are \\b \\f \\n \\r \\t \\\\ \\' \\\"",
                                     Excerpt({&*badEscape, 1}), token.Excerpt()));
    if (!hasEscapes) return token;
    std::string plain;
    for (size_t i = 0; i < token.text.size(); ++i)
        plain += token.text[i] == '\\' ? *Unescape(token.text[++i]) : token.text[i];
    unescaped_.push_back(std::move(plain));
    token.text = unescaped_.back();
    return token;
}

NumberProblem ParseFloat(std::string_view text, float* value) {
    text = WithoutPlus(text);
    const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
    // Rejects what from_chars takes beyond the grammar: "inf", "nan".
    if (digits.empty() || !(IsDigit(digits[0]) || (digits[0] == '.' && text.size() > 1)))
        return NumberProblem::Malformed;
    if (IsHex(digits)) return ParseHex(digits, digits.size() != text.size(), value);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
    if (end != text.data() + text.size() || error == std::errc::invalid_argument)
        return NumberProblem::Malformed;
    return error == std::errc() ? NumberProblem::None : ParseExtreme(text, value);
}

NumberProblem ParseInteger(std::string_view text, int* value) {
    text = WithoutPlus(text);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
    if (text.empty() || end != text.data() + text.size() || error == std::errc::invalid_argument)
        return NumberProblem::Malformed;
    return error == std::errc() ? NumberProblem::None : NumberProblem::TooLarge;
}

}  // namespace lacquer
