// Scene text to tokens.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/scene/source.h"

namespace lacquer {

struct Token {
    enum class Kind { End, Word, String, Open, Close, Comment };

    Kind kind = Kind::End;
    std::string_view text;  ///< a string without its quotes, escapes resolved
    FileName file;
    int line = 0, column = 0;  ///< from 1, of the first character

    FileLoc Loc() const { return {file, line, column}; }
    /// The token as it is quoted in messages, shortened.
    std::string Excerpt() const;
};

/// Tokens of a stack of texts: at the end of one the text below it goes on.
/// The text of a token lives until two more tokens have been read.
class Lexer {
  public:
    /// Kept ones are tokens, from their # to the last character of the line that is no blank.
    enum class Comments { Skip, Keep };
    explicit Lexer(Source source, Comments comments = Comments::Skip) : comments_(comments) {
        Push(std::move(source));
    }
    /// Goes on with another text. No token may be pending from Peek().
    void Push(Source source);

    /// The next token; kind End for ever once all texts are used up.
    /// Errors: SceneError for bad strings; the lexer goes on behind them.
    Token Next();
    const Token& Peek();
    /// Number of texts on the stack.
    size_t Depth() const { return frames_.size(); }
    /// True if a text with this key is on the stack.
    bool IsOpen(const std::string& key) const;
    /// Adds the keys of the texts on the stack.
    void AppendOpen(std::vector<std::string>* keys) const;

  private:
    struct Frame {
        std::shared_ptr<const void> memory;  // of the text
        std::string key;
        FileName name;
        const char *at = nullptr, *end = nullptr, *lineStart = nullptr;
        int line = 1;
    };
    void SkipBlanks(Frame& frame) const;
    Token Scan();
    Token ScanString(Frame& frame);
    static Token ScanComment(Frame& frame, Token token);

    Comments comments_;
    std::vector<std::unique_ptr<Frame>> frames_, finished_;
    std::deque<std::string> unescaped_;  // strings that had escapes
    std::optional<Token> pending_;
    Token last_;
};

/// Numbers as the format has them; no value if the text is not one.
/// Floats: decimal or hexadecimal integers, no "inf" or "nan". Overflow is an error, underflow gives 0.
enum class NumberProblem { None, Malformed, TooLarge };
NumberProblem ParseFloat(std::string_view text, float* value);
/// Optional sign and digits, 32 bits.
NumberProblem ParseInteger(std::string_view text, int* value);

}  // namespace lacquer
