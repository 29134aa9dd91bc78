// A scene file as it is written: directives with their spelling, comments and order, for tools that change
// scene files. Says nothing about what the directives mean.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/error.h"
#include "pbrt/scene/lexer.h"
#include "pbrt/scene/source.h"

namespace lacquer {

/// A number, a word, or a string. Numbers keep their spelling, so that writing them again changes no bit.
struct WrittenValue {
    std::string_view
        text;  ///< of a string without its quotes, escapes resolved; lives as long as the SceneText
    bool isString = false;
};

/// `"type name" values`
struct WrittenParameter {
    std::string type, name;
    std::vector<WrittenValue> values;
    FileLoc loc;
    std::vector<std::string> commentsBefore;
    std::string commentBehind;  ///< on the line of its last value
};

/// A directive.
struct WrittenDirective {
    std::string name;
    std::vector<WrittenValue> arguments;  ///< without the brackets of a matrix
    std::vector<WrittenParameter> parameters;
    FileLoc loc;
    std::vector<std::string> commentsBefore;  ///< an empty one is a blank line
    std::string commentBehind;                ///< on the line of its last argument

    WrittenParameter* Find(std::string_view parameter);
};

/// The directives of one text.
struct SceneText {
    std::vector<WrittenDirective> directives;
    std::vector<std::string> commentsAtEnd;

    /// Keeps a text for a value.
    std::string_view Own(std::string text) { return *owned_.insert(owned_.end(), std::move(text)); }
    /// What the views point to: the text itself.
    std::shared_ptr<const void> memory;

  private:
    std::deque<std::string> owned_;
};

/// Reads directives, those of pbrt-v3 as well. What they include is not read. Comments within a list of
/// values move before it. Errors: SceneError for what is no directive, or has not the arguments of one.
SceneText ReadSceneText(const Source& source);

/// A text within quotes, with the escapes of the format.
std::string QuotedText(std::string_view text);

/// Writes them with one directive a line, or parameter by parameter where that is too long, indented by
/// scopes. Reading the result gives the same directives, and writing them again the same text.
std::string WriteSceneText(const SceneText& scene);

}  // namespace lacquer
