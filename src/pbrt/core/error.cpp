#include "pbrt/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>

namespace lacquer {

std::string FileLoc::ToString() const {
    if (line == 0) return file;
    return fmt::format("{}:{}:{}", file.Text(), line, column);
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
      loc_(loc),
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

char Lower(char c) { return char(std::tolower(static_cast<unsigned char>(c))); }

constexpr size_t kMaxNameLength = 100;

/// Edits that turn `name` into `candidate`, whatever the case: insertions, deletions, substitutions and swaps
/// of neighbours (optimal string alignment distance); `limit` where there are as many or more.
/// @param name  in lower case, at most kMaxNameLength
int EditDistance(std::string_view name, std::string_view candidate, int limit) {
    if (std::abs(int(name.size()) - int(candidate.size())) >= limit) return limit;
    const size_t n = name.size();
    // Rows of the candidate's character before last, of the last, and of this one.
    std::array<std::array<int, kMaxNameLength + 1>, 3> rows;
    std::iota(rows[0].begin(), rows[0].begin() + std::ptrdiff_t(n) + 1, 0);
    for (size_t j = 1; j <= candidate.size(); ++j) {
        const auto &before = rows[(j + 1) % 3], &last = rows[(j + 2) % 3];
        auto& row = rows[j % 3];
        const char c = Lower(candidate[j - 1]);
        int least = row[0] = int(j);
        for (size_t i = 1; i <= n; ++i) {
            row[i] = std::min({row[i - 1] + 1, last[i] + 1, last[i - 1] + (name[i - 1] != c)});
            if (i > 1 && j > 1 && name[i - 2] == c && name[i - 1] == Lower(candidate[j - 2]))
                row[i] = std::min(row[i], before[i - 2] + 1);
            least = std::min(least, row[i]);
        }
        // What follows builds on this row or, by a swap, on the last one, which is less by one at most.
        if (least >= limit) return limit;
    }
    return std::min(limit, rows[candidate.size() % 3][n]);
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
      loc_(loc) {}

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
    if (name.size() > kMaxNameLength) return {};
    std::string wanted(name);
    std::transform(wanted.begin(), wanted.end(), wanted.begin(), Lower);
    const std::string* best = nullptr;
    int bestDistance = std::max(1, int(name.size()) / 3) + 1;
    for (const std::string& candidate : candidates) {
        const int distance = EditDistance(wanted, candidate, bestDistance);
        if (distance < bestDistance) {
            bestDistance = distance;
            best = &candidate;
        }
    }
    return best ? *best : std::string();
}

std::string DidYouMean(std::string_view name, std::span<const std::string> candidates) {
    const std::string nearest = NearestName(name, candidates);
    return nearest.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", nearest);
}

}  // namespace lacquer
