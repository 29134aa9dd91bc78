#include "pbrt/scene/lexer.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>

#include "scene/scene_text.h"

namespace lacquer::test::lexer_test {
namespace {

using Kind = Token::Kind;

Lexer LexerOf(const std::string& text) { return Lexer(SourceOf("a.pbrt", text)); }

std::vector<std::string> TextsOf(const std::string& text) {
    Lexer lexer = LexerOf(text);
    std::vector<std::string> texts;
    for (Token token = lexer.Next(); token.kind != Kind::End; token = lexer.Next())
        texts.emplace_back(token.text);
    return texts;
}

float FloatOf(const std::string& text) {
    float value = -1;
    EXPECT_EQ(ParseFloat(text, &value), NumberProblem::None) << text;
    return value;
}

int IntegerOf(const std::string& text) {
    int value = -1;
    EXPECT_EQ(ParseInteger(text, &value), NumberProblem::None) << text;
    return value;
}

NumberProblem FloatProblem(const std::string& text) {
    float value = 0;
    return ParseFloat(text, &value);
}

NumberProblem IntegerProblem(const std::string& text) {
    int value = 0;
    return ParseInteger(text, &value);
}

void ExpectLexError(const std::string& text, int line, int column, const std::string& part) {
    Lexer lexer = LexerOf(text);
    try {
        while (lexer.Next().kind != Kind::End) {
        }
        FAIL() << "no error for " << text;
    } catch (const SceneError& e) {
        EXPECT_EQ(e.Loc().line, line);
        EXPECT_EQ(e.Loc().column, column);
        EXPECT_NE(e.Message().find(part), std::string::npos) << e.Message();
    }
}

TEST(Lexer, WordsStringsAndBracketsNeedNoBlanksBetweenThem) {
    EXPECT_EQ(TextsOf("Shape\"sphere\"[1 2]\t3\r\n4"),
              (std::vector<std::string>{"Shape", "sphere", "[", "1", "2", "]", "3", "4"}));
}

TEST(Lexer, PlacesCountFromOne) {
    Lexer lexer = LexerOf("ab cd\n  \"e\"\n\n[");
    EXPECT_EQ(lexer.Next().Loc().ToString(), "a.pbrt:1:1");
    EXPECT_EQ(lexer.Next().Loc().ToString(), "a.pbrt:1:4");
    EXPECT_EQ(lexer.Next().Loc().ToString(), "a.pbrt:2:3");
    EXPECT_EQ(lexer.Next().Loc().ToString(), "a.pbrt:4:1");
    EXPECT_EQ(lexer.Next().kind, Kind::End);
    EXPECT_EQ(lexer.Next().kind, Kind::End);
}

TEST(Lexer, CommentsEndWithTheLineAndBeginOnlyWhereATokenCould) {
    EXPECT_EQ(TextsOf("a # b \"c\n3#foo #\n#x\nd#"), (std::vector<std::string>{"a", "3#foo", "d#"}));
}

TEST(Lexer, FormFeedIsNoBlank) { EXPECT_EQ(TextsOf("a\fb"), (std::vector<std::string>{"a\fb"})); }

TEST(Lexer, EscapesStandForTheirCharacters) {
    EXPECT_EQ(TextsOf(R"("a\"b\\\'\n\r\t\b\f" "plain")"),
              (std::vector<std::string>{"a\"b\\'\n\r\t\b\f", "plain"}));
}

TEST(Lexer, LineFeedInAStringIsAnErrorAtItsQuote) {
    ExpectLexError("a\n \"bc\ndef\"", 2, 2, "unterminated string");
}

TEST(Lexer, EndOfFileInAStringIsAnError) {
    ExpectLexError("\"bc", 1, 1, "unterminated string");
    ExpectLexError("\"bc\\", 1, 1, "unterminated string");
    ExpectLexError("\"bc\\\"", 1, 1, "unterminated string");
}

TEST(Lexer, UnknownEscapesAreErrors) { ExpectLexError("x \"a\\qb\"", 1, 3, "unknown escape \\q"); }

TEST(Lexer, GoesOnAfterAnError) {
    Lexer lexer = LexerOf("\"a\nnext \"b\\q\" last");
    EXPECT_THROW(lexer.Next(), SceneError);
    EXPECT_EQ(lexer.Next().text, "next");
    EXPECT_THROW(lexer.Peek(), SceneError);
    EXPECT_EQ(lexer.Next().text, "last");
}

TEST(Lexer, ATextBelowGoesOnWhereItWas) {
    Lexer lexer = LexerOf("a b c");
    EXPECT_EQ(lexer.Next().text, "a");
    Source inner = SourceOf("inner", "x y");
    inner.key = "key";
    lexer.Push(std::move(inner));
    EXPECT_TRUE(lexer.IsOpen("key"));
    EXPECT_EQ(lexer.Next().text, "x");
    const Token y = lexer.Next();
    EXPECT_EQ(lexer.Peek().text, "b");
    EXPECT_EQ(y.text, "y");  // the text of an ended file lives on for one more token
    EXPECT_FALSE(lexer.IsOpen("key"));
    EXPECT_EQ(lexer.Next().Loc().ToString(), "a.pbrt:1:3");
}

TEST(Numbers, AcceptsEverySpellingOfTheFormat) {
    EXPECT_EQ(FloatOf("1"), 1.f);
    EXPECT_EQ(FloatOf("+1"), 1.f);
    EXPECT_EQ(FloatOf("-1"), -1.f);
    EXPECT_EQ(FloatOf(".5"), .5f);
    EXPECT_EQ(FloatOf("-.5"), -.5f);
    EXPECT_EQ(FloatOf("+.5"), .5f);
    EXPECT_EQ(FloatOf("1."), 1.f);
    EXPECT_EQ(FloatOf("1e3"), 1000.f);
    EXPECT_EQ(FloatOf("1.5E-2"), 1.5e-2f);
    EXPECT_EQ(FloatOf("1e+2"), 100.f);
    EXPECT_EQ(FloatOf("0x10"), 16.f);
    EXPECT_EQ(FloatOf("-0XfF"), -255.f);
    EXPECT_EQ(FloatOf("16777217"), 16777216.f);
    EXPECT_EQ(FloatOf("0.1"), 0.1f);
    EXPECT_EQ(FloatOf("007"), 7.f);
}

TEST(Numbers, RejectsWhatIsNoNumber) {
    for (const char* text :
         {"",    "inf", "-inf", "nan", "NaN", "infinity", "1f", "1,",    ".",     "-",   "+",  "+-1",
          "-+1", "1e",  "1e+",  "0x",  "0xg", "--1",      "e5", "1.2.3", "3#foo", "++1", "-.", "1e5x"})
        EXPECT_EQ(FloatProblem(text), NumberProblem::Malformed) << text;
}

TEST(Numbers, OverflowIsAProblemAndUnderflowIsZero) {
    for (const char* text : {"1e39", "-1e39", "1e400", "1e99999", "0x1ffffffffffffffff"})
        EXPECT_EQ(FloatProblem(text), NumberProblem::TooLarge) << text;
    EXPECT_EQ(FloatProblem(std::string(400, '9')), NumberProblem::TooLarge);
    EXPECT_EQ(FloatOf("1e-60"), 0.f);
    EXPECT_EQ(FloatOf("1e-400"), 0.f);
    EXPECT_EQ(FloatOf("0." + std::string(400, '0') + "1"), 0.f);
    EXPECT_GT(FloatOf("1e-40"), 0.f);
}

TEST(Numbers, IntegersAreStrict) {
    EXPECT_EQ(IntegerOf("42"), 42);
    EXPECT_EQ(IntegerOf("+42"), 42);
    EXPECT_EQ(IntegerOf("-2147483648"), -2147483647 - 1);
    for (const char* text : {"4.0", "", "x", "1e3", "0x10", "+", "-", "+-1"})
        EXPECT_EQ(IntegerProblem(text), NumberProblem::Malformed) << text;
    EXPECT_EQ(IntegerProblem("2147483648"), NumberProblem::TooLarge);
    EXPECT_EQ(IntegerProblem("99999999999999999999"), NumberProblem::TooLarge);
}

std::string WriteGzip(const TestFolder& folder, const std::string& name, const std::string& text) {
    const std::string path = folder.Path(name);
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, text.data(), unsigned(text.size()));
    gzclose(file);
    return path;
}

TEST(Source, ReadsPlainAndGzippedText) {
    const TestFolder folder;
    std::string text;
    for (int i = 0; i < 50000; ++i) text += std::to_string(i * 7919) + " ";
    EXPECT_EQ(ReadSource(folder.Write("a.pbrt", text)).text, text);
    EXPECT_EQ(ReadSource(WriteGzip(folder, "a.pbrt.gz", text)).text, text);
    EXPECT_EQ(ReadSource(folder.Write("empty.pbrt", "")).text, "");
    EXPECT_EQ(ReadSource(WriteGzip(folder, "empty.pbrt.gz", "")).text, "");
}

TEST(Source, StopsAtTheLimitAlsoWhileInflating) {
    const TestFolder folder;
    const std::string text(300000, ' ');
    EXPECT_THROW(ReadSource(folder.Write("a.pbrt", text), {}, 299999), FileError);
    EXPECT_THROW(ReadSource(WriteGzip(folder, "a.pbrt.gz", text), {}, 299999), FileError);
    EXPECT_EQ(ReadSource(folder.Path("a.pbrt"), {}, 300000).text.size(), 300000u);
    EXPECT_EQ(ReadSource(folder.Path("a.pbrt.gz"), {}, 300000).text.size(), 300000u);
    // An endless file ends there too; a scene may not even name one.
    EXPECT_THROW(ReadSource("/dev/zero", {}, 1000000), FileError);
    EXPECT_THROW(ReadSource("/dev/null", {"scene.pbrt", 1, 1}), FileError);
    EXPECT_EQ(ReadSource("/dev/null").text, "");
}

TEST(Source, SaysWhatIsWrongWithAFile) {
    const TestFolder folder;
    EXPECT_THROW(ReadSource(folder.Path("missing.pbrt")), FileError);
    EXPECT_THROW(ReadSource(folder.Path("missing.pbrt.gz")), FileError);
    EXPECT_THROW(ReadSource(folder.Path("")), FileError);
    EXPECT_THROW(ReadSource(folder.Write("plain.pbrt.gz", "WorldBegin")), SceneError);
    std::string text;
    for (int i = 0; i < 20000; ++i) text += std::to_string(i * 7919);
    const std::string whole = WriteGzip(folder, "whole.pbrt.gz", text);
    std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 2);
    EXPECT_THROW(ReadSource(whole), SceneError);
    EXPECT_THROW(ReadSource(folder.Write("noise.pbrt.gz", "\x1f\x8b\x08rubbish that is no deflate stream")),
                 SceneError);
}

TEST(Source, RejectsByteOrderMarks) {
    const TestFolder folder;
    for (const char* mark : {"\xFE\xFF", "\xFF\xFE", "\xEF\xBB\xBF"}) {
        try {
            ReadSource(folder.Write("a.pbrt", std::string(mark) + "WorldBegin"));
            FAIL();
        } catch (const SceneError& e) {
            EXPECT_EQ(e.Loc().line, 1);
            EXPECT_EQ(e.Loc().column, 1);
        }
    }
}

/// The problem with a text, and its place; empty if there is none.
std::string ProblemOf(const std::string& text) {
    try {
        RejectOtherThanText(SourceOf("a", text));
    } catch (const SceneError& e) {
        return e.what();
    }
    return "";
}

TEST(Source, RejectsWhatIsNoText) {
    EXPECT_EQ(ProblemOf(std::string("\0", 1)), "a:1:1: error: this is not a text file: it holds a NUL byte");
    EXPECT_EQ(ProblemOf(std::string("# x\n  \0y\0", 9)),
              "a:2:3: error: this is not a text file: it holds a NUL byte");
    // Eight control characters are rejected where they are more than one in 32.
    const std::string strange("\x01\x02\x0e\x0f\x10\x7f\x1f\x08", 8);
    EXPECT_EQ(ProblemOf(strange), "a:1:1: error: this is not a text file: it is full of control characters");
    EXPECT_EQ(ProblemOf(strange + std::string(247, 'x')).substr(0, 12), "a:1:1: error");
    EXPECT_EQ(ProblemOf(strange + std::string(248, 'x')), "");
    EXPECT_EQ(ProblemOf(strange.substr(1)), "");
    EXPECT_EQ(ProblemOf(""), "");
    EXPECT_EQ(ProblemOf("\t\n\v\f\r\x1b" + std::string("caf\xc3\xa9 caf\xe9")), "");
}

TEST(Source, HasOneKeyForAllPathsOfAFile) {
    const TestFolder folder;
    folder.Write("a.pbrt", "");
    folder.Write("b/c.pbrt", "");
    EXPECT_EQ(ReadSource(folder.Path("a.pbrt")).key, ReadSource(folder.Path("b/../a.pbrt")).key);
}

}  // namespace
}  // namespace lacquer::test::lexer_test
