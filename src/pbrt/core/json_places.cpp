#include "pbrt/core/json_places.h"

#include <algorithm>
#include <charconv>
#include <set>

namespace lacquer {

FileLoc JsonPlaces::LocOf(size_t byte) const {
    const std::string_view before = text_.substr(0, byte);
    const size_t newline = before.rfind('\n');
    const size_t lineStart = newline == std::string_view::npos ? 0 : newline + 1;
    return {file_, int(std::count(before.begin(), before.end(), '\n')) + 1,
            int(before.size() - lineStart) + 1};
}

size_t JsonPlaces::SkipBlanks(size_t i) const {
    return std::min(text_.find_first_not_of(" \t\r\n", i), text_.size());
}

size_t JsonPlaces::SkipString(size_t i) const {
    for (++i; i < text_.size() && text_[i] != '"'; ++i)
        if (text_[i] == '\\') ++i;
    return std::min(i + 1, text_.size());
}

size_t JsonPlaces::SkipValue(size_t i) const {
    int depth = 0;
    while (i < text_.size()) {
        const char c = text_[i];
        if (c == '"') {
            i = SkipString(i);
        } else if (c == '{' || c == '[') {
            ++depth, ++i;
        } else if (c == '}' || c == ']') {
            --depth, ++i;
        } else {
            // A number or a word, or, inside of brackets, what parts values.
            i = std::min(text_.find_first_of(depth > 0 ? "\"{}[]" : ",}] \t\r\n", i), text_.size());
        }
        if (depth == 0) return i;
    }
    return i;
}

std::vector<JsonPlaces::Entry> JsonPlaces::Entries(size_t i) const {
    std::vector<Entry> entries;
    if (i >= text_.size() || (text_[i] != '{' && text_[i] != '[')) return entries;
    const bool isObject = text_[i] == '{';
    for (i = SkipBlanks(i + 1); i < text_.size() && text_[i] != '}' && text_[i] != ']'; i = SkipBlanks(i)) {
        Entry entry{{}, i, i};
        if (isObject) {
            const size_t end = SkipString(i);
            entry.key = text_.substr(i + 1, end - i - 2);
            entry.valueAt = SkipBlanks(SkipBlanks(end) + 1);
        }
        entries.push_back(entry);
        i = SkipBlanks(SkipValue(entry.valueAt));
        if (i < text_.size() && text_[i] == ',') ++i;
    }
    return entries;
}

size_t JsonPlaces::FindByte(std::string_view pointer) const {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    size_t at = SkipBlanks(text_.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
    while (!pointer.empty()) {
        pointer.remove_prefix(1);
        const std::string_view step = pointer.substr(0, pointer.find('/'));
        pointer.remove_prefix(step.size());
        const std::vector<Entry> entries = Entries(at);
        if (entries.empty()) return at;
        size_t index = entries.size();
        if (text_[at] == '[')
            std::from_chars(step.data(), step.data() + step.size(), index);
        else
            for (size_t i = 0; i < entries.size(); ++i)
                if (entries[i].key == step) index = i;
        if (index >= entries.size()) return at;
        at = entries[index].valueAt;
    }
    return at;
}

FileLoc JsonPlaces::Find(std::string_view pointer) const { return LocOf(FindByte(pointer)); }

FileLoc JsonPlaces::FindKey(std::string_view pointer, std::string_view key) const {
    size_t at = FindByte(pointer);
    for (const Entry& entry : Entries(at))
        if (entry.key == key) at = entry.keyAt;
    return LocOf(at);
}

FileLoc JsonPlaces::FindRepeatedKey() const {
    std::vector<std::set<std::string_view>> open;  // keys of the objects about a place; none for arrays
    for (size_t i = 0; i < text_.size(); ++i) {
        const char c = text_[i];
        if (c == '{' || c == '[') open.emplace_back();
        if ((c == '}' || c == ']') && !open.empty()) open.pop_back();
        if (c != '"') continue;
        const size_t begin = i, end = SkipString(i), next = SkipBlanks(end);
        const bool isKey = next < text_.size() && text_[next] == ':' && !open.empty();
        if (isKey && !open.back().insert(text_.substr(begin + 1, end - begin - 2)).second)
            return LocOf(begin);
        i = end - 1;
    }
    return {file_, 0, 0};
}

FileLoc JsonPlaces::FindDeeperThan(int limit) const {
    int depth = 0;
    for (size_t i = 0; i < text_.size(); ++i) {
        const char c = text_[i];
        if (c == '"') i = SkipString(i) - 1;
        if ((c == '{' || c == '[') && ++depth > limit) return LocOf(i);
        depth -= c == '}' || c == ']';
    }
    return {file_, 0, 0};
}

}  // namespace lacquer
