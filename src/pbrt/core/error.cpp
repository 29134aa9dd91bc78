#include "pbrt/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace lacquer {

std::string FileLoc::ToString() const {
    if (line == 0) return file;
    return fmt::format("{}:{}:{}", file, line, column);
}

std::string Diagnostic::ToString() const {
    const std::string place = loc.ToString();
    const char* kind = severity == Severity::Error ? "error" : "warning";
    return place.empty() ? fmt::format("{}: {}", kind, message)
                         : fmt::format("{}: {}: {}", place, kind, message);
}

SceneError::SceneError(FileLoc loc, const std::string& message)
    : std::runtime_error(
          Diagnostic{Diagnostic::Severity::Error, loc, message, Diagnostic::Cause::Scene}.ToString()),
      loc_(std::move(loc)),
      message_(message) {}

namespace {

std::string Join(const std::vector<Diagnostic>& diagnostics) {
    std::string text;
    for (const Diagnostic& d : diagnostics) {
        if (!text.empty()) text += '\n';
        text += d.ToString();
    }
    return text;
}

std::string Lower(std::string_view text) {
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return lower;
}

// Edits that turn a into b: insertions, deletions, substitutions and swaps of neighbours (optimal string
// alignment distance).
int EditDistance(const std::string& a, const std::string& b) {
    const size_t n = a.size(), m = b.size();
    std::vector<std::vector<int>> d(n + 1, std::vector<int>(m + 1));
    for (size_t i = 0; i <= n; ++i) d[i][0] = int(i);
    for (size_t j = 0; j <= m; ++j) d[0][j] = int(j);
    for (size_t i = 1; i <= n; ++i)
        for (size_t j = 1; j <= m; ++j) {
            const int substitution = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, substitution});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[n][m];
}

}  // namespace

SceneErrors::SceneErrors(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(Join(diagnostics)), diagnostics_(std::move(diagnostics)) {}

FileError::FileError(const std::string& path, const std::string& problem, FileLoc loc)
    : std::runtime_error(Diagnostic{Diagnostic::Severity::Error, loc, fmt::format("{}: {}", path, problem),
                                    Diagnostic::Cause::File}
                             .ToString()),
      path_(path),
      problem_(problem),
      message_(fmt::format("{}: {}", path, problem)),
      loc_(std::move(loc)) {}

std::string Excerpt(std::string_view text) {
    constexpr size_t kLongest = 40;
    size_t length = std::min(text.size(), kLongest);
    // The cut goes before the UTF-8 character that it would split.
    if (length < text.size())
        while (length > kLongest - 4 && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
    std::string result(text.substr(0, length));
    for (char& c : result)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return length < text.size() ? result + "..." : result;
}

std::string NearestName(std::string_view name, std::span<const std::string> candidates) {
    if (name.size() > 100) return {};
    const std::string wanted = Lower(name);
    std::string best;
    int bestDistance = std::max(1, int(name.size()) / 3) + 1;
    for (const std::string& candidate : candidates) {
        const int distance = EditDistance(wanted, Lower(candidate));
        if (distance < bestDistance) {
            bestDistance = distance;
            best = candidate;
        }
    }
    return best;
}

std::string DidYouMean(std::string_view name, std::span<const std::string> candidates) {
    const std::string nearest = NearestName(name, candidates);
    return nearest.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", nearest);
}

}  // namespace lacquer
