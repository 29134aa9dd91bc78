#include "cmd/printable.h"

#include <algorithm>

namespace lacquer::cmd {
namespace {

/// Bytes of the UTF-8 character that begins at `at`; 0 if there is none, or a control character.
size_t CharacterLength(const std::string& text, size_t at) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const unsigned first = byte(at);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    if (first < 0xc2 || first > 0xf4) return 0;
    const size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    for (size_t i = 1; i < length; ++i)
        if ((byte(at + i) & 0xc0) != 0x80) return 0;
    // U+0080 to U+009F steer terminals as well.
    return first == 0xc2 && byte(at + 1) < 0xa0 ? 0 : length;
}

std::string WithoutControls(const std::string& text, const char* allowed) {
    std::string result;
    for (size_t at = 0; at < text.size();) {
        const size_t length = CharacterLength(text, at);
        if (length == 0)
            result += std::string(allowed).find(text[at]) != std::string::npos ? text[at] : '?';
        else
            result.append(text, at, length);
        at += std::max<size_t>(1, length);
    }
    return result;
}

}  // namespace

std::string Printable(const std::string& text) { return WithoutControls(text, "\t\n"); }
std::string PrintableName(const std::string& name) { return WithoutControls(name, ""); }

}  // namespace lacquer::cmd
