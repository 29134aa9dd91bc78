// The table of directives: parser and formatter read each row alike.
#include "pbrt/scene/directive.h"

#include <gtest/gtest.h>

#include "pbrt/scene/parser.h"
#include "pbrt/scene/statements.h"

namespace lacquer::directive_test {
namespace {

/// An argument that every directive takes, as the formatter writes it.
std::string TextOf(Argument argument) {
    switch (argument) {
        case Argument::None:
        case Argument::Parameters:
            return "";
        case Argument::Type:
            return " \"none\"";
        case Argument::ValueType:
            return " \"float\"";
        case Argument::Target:
            return " \"shape\"";
        case Argument::Times:
            return " All";
        case Argument::Value:
            return " true";
        case Argument::Number:
            return " 1";
        case Argument::Vector:
            return " 1 2 4";
        case Argument::Matrix:
            return " [ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 ]";
        default:
            return " \"a\"";
    }
}

std::string TextOf(const Directive& directive) {
    std::string text(directive.name);
    for (const Argument argument : directive.arguments) text += TextOf(argument);
    return text;
}

std::string Format(const std::string& text) { return WriteSceneText(ReadSceneText(SourceOf("text", text))); }

/// What the parser says about a text, whatever it means.
std::string ParserSays(const std::string& text) {
    try {
        ParseText(text, "t", ".", nullptr);
        return "";
    } catch (const std::exception& e) {
        return e.what();
    }
}

TEST(DirectiveTable, EveryRowIsFoundByItsName) {
    ASSERT_EQ(Directives().size(), 46u);
    for (const Directive& directive : Directives()) {
        EXPECT_EQ(FindDirective(directive.name), &directive) << directive.name;
        EXPECT_EQ(!directive.run, directive.advice != nullptr) << directive.name;
    }
    for (const char* name : {"", "A", "camera", "Cameras", "Zoom"}) EXPECT_EQ(FindDirective(name), nullptr);
}

TEST(DirectiveTable, FormatterWritesEveryRowAsItIs) {
    for (const Directive& directive : Directives())
        EXPECT_EQ(Format(TextOf(directive)), TextOf(directive) + "\n") << directive.name;
}

// The arguments end where the table says: one too few or too many is noticed.
TEST(DirectiveTable, ParserTakesTheArgumentsOfEveryRow) {
    const auto says = [](const std::string& text, const char* what) {
        return ParserSays(text).find(what) != std::string::npos;
    };
    int numExtended = 0, numTruncated = 0;
    for (const Directive& directive : Directives()) {
        if (!directive.run) continue;
        const std::string text = TextOf(directive);
        EXPECT_FALSE(says(text + "\nIdentity", ": expected")) << ParserSays(text + "\nIdentity");
        // Behind a directive that makes no sense here (an end without a beginning), everything is skipped.
        if (!says(text, "t:1:1")) {
            ++numExtended;
            EXPECT_TRUE(says(text + " 1", "unknown directive 1")) << text;
        }
        const Argument last = directive.Has(Argument::Parameters) ? Argument::Name : directive.arguments[0];
        if (last == Argument::None || directive.Has(Argument::OtherMedium) || directive.Has(Argument::Value))
            continue;
        ++numTruncated;
        const std::string few = text.substr(0, text.rfind(' ')) + "\nIdentity";
        EXPECT_TRUE(says(few, ": expected")) << few << ": " << ParserSays(few);
    }
    EXPECT_GE(numExtended, 8);
    EXPECT_EQ(numTruncated, 30);
}

TEST(DirectiveTable, BothReadersSayTheSame) {
    for (const char* text : {"Translate 1 2 x", "Shape sphere", "Transform [1 2 3]", "LookAt 1 2 3",
                             "ActiveTransform All1", "Texture \"a\" float"}) {
        std::string formatter;
        try {
            Format(text);
        } catch (const SceneError& e) {
            formatter = e.Message();
        }
        EXPECT_FALSE(formatter.empty()) << text;
        EXPECT_NE(ParserSays("WorldBegin " + std::string(text)).find(formatter), std::string::npos)
            << formatter << "\n"
            << ParserSays("WorldBegin " + std::string(text));
    }
}

TEST(DirectiveTable, NamesForMessagesLeaveOutPbrtV3) {
    const std::vector<std::string> names = DirectiveNames();
    EXPECT_EQ(names.size(), 40u);
    EXPECT_EQ(NearestName("MakeNamedMaterail", names), "MakeNamedMaterial");
    EXPECT_EQ(NearestName("Volumes", names), "");
}

}  // namespace
}  // namespace lacquer::directive_test
