// What tests of pages ask of their text.
#pragma once

#include <regex>
#include <string>

namespace lacquer::cmd {

/// A name that wants to become something else.
inline constexpr const char* kHostile =
    "</script><script>alert(1)</script><!-- & \" ' {{images}} \xe2\x80\xa8";

/// What would make a browser ask for something: an address in an attribute, a style or a script's call.
inline bool Loads(const std::string& page) {
    static const std::regex kLoad(
        R"re((src|href|action|poster|data)\s*=\s*["']?\s*(https?:)?//|url\(\s*["']?\s*(https?:)?//|@import|)re"
        R"re(\bimport\s*\(|importScripts|XMLHttpRequest|\bfetch\s*\(|WebSocket|sendBeacon|<link|<iframe)re");
    return std::regex_search(page, kLoad);
}

/// Text between two marks, which have to be there.
inline std::string Between(const std::string& text, const std::string& open, const std::string& close) {
    const size_t begin = text.find(open);
    if (begin == std::string::npos) return "nothing opens it";
    return text.substr(begin + open.size(), text.find(close, begin + open.size()) - begin - open.size());
}

inline size_t Count(const std::string& text, const std::string& what) {
    size_t count = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size()))
        ++count;
    return count;
}

}  // namespace lacquer::cmd
