#include "pbrt/core/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace lacquer {

namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

}  // namespace

std::string_view Words::Next() {
    SkipBlanks();
    wordStart_ = at_;
    while (at_ < text_.size() && !IsBlank(text_[at_]) && text_[at_] != '#') ++at_;
    return text_.substr(wordStart_, at_ - wordStart_);
}

void Words::SkipBlanks() {
    for (; at_ < text_.size() && (IsBlank(text_[at_]) || text_[at_] == '#'); ++at_) {
        if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size() - 1);
        if (text_[at_] != '\n') continue;
        ++loc_.line;
        lineStart_ = at_ + 1;
    }
}

float ParseNumber(std::string_view word, const FileLoc& loc) {
    float value = 0;
    const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
        throw SceneError(loc, fmt::format("\"{}\" is not a number", Excerpt(word)));
    return value;
}

}  // namespace lacquer
