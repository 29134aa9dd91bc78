// Text files of numbers: their words, with places for messages.
#pragma once

#include <string>
#include <string_view>

#include "pbrt/core/error.h"

namespace lacquer {

/// The words of a text with their places; blanks part them, '#' starts a comment that ends with its line.
class Words {
  public:
    /// @param text  must outlive the object    @param file  its name, for messages
    Words(std::string_view text, const std::string& file) : text_(text), loc_{file, 1, 1} {}
    /// Place of the word that Next() returned last.
    FileLoc Loc() const { return {loc_.file, loc_.line, int(wordStart_ - lineStart_) + 1}; }
    /// The next word, empty at the end.
    std::string_view Next();

  private:
    void SkipBlanks();

    std::string_view text_;
    FileLoc loc_;
    size_t at_ = 0, lineStart_ = 0, wordStart_ = 0;
};

/// The finite number that `word` is as a whole. Errors: SceneError at `loc`.
float ParseNumber(std::string_view word, const FileLoc& loc);

}  // namespace lacquer
