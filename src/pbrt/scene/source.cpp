#include "pbrt/scene/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "pbrt/core/file_bytes.h"

namespace lacquer {

namespace {

void RejectByteOrderMark(const Source& source) {
    const FileLoc start{source.name, 1, 1};
    if (source.text.starts_with("\xFE\xFF") || source.text.starts_with("\xFF\xFE"))
        throw SceneError(start, "the file is in UTF-16; save it as UTF-8");
    if (source.text.starts_with("\xEF\xBB\xBF"))
        throw SceneError(start, "the file begins with a UTF-8 byte-order mark; save it without one");
}

// Control characters without a meaning in texts: all but tabs, line ends, form feeds and escapes.
bool IsStrange(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte == 0x7f || (byte < 0x20 && !(byte >= '\t' && byte <= '\r') && byte != 0x1b);
}

FileLoc PlaceOf(size_t at, const Source& source) {
    const std::string_view before = source.text.substr(0, at);
    const size_t lineStart = before.rfind('\n') + 1;  // npos + 1 is 0
    return {source.name, int(std::count(before.begin(), before.end(), '\n')) + 1, int(at - lineStart) + 1};
}

}  // namespace

void RejectOtherThanText(const Source& source) {
    constexpr size_t kExamined = 4096, kMin = 8, kShare = 32;
    RejectByteOrderMark(source);
    if (const size_t nul = source.text.find('\0'); nul != std::string_view::npos)
        throw SceneError(PlaceOf(nul, source), "this is not a text file: it holds a NUL byte");
    const std::string_view start = source.text.substr(0, kExamined);
    const auto numStrange = size_t(std::count_if(start.begin(), start.end(), IsStrange));
    if (numStrange >= kMin && numStrange * kShare > start.size())
        throw SceneError({source.name, 1, 1}, "this is not a text file: it is full of control characters");
}

Source SourceOf(std::string name, std::string text) {
    const auto memory = std::make_shared<const std::string>(std::move(text));
    return {std::move(name), *memory, {}, memory};
}

Source ReadSource(const std::string& path, const FileLoc& loc, size_t limit) {
    const bool isNamedByScene = !loc.file.IsEmpty();
    const auto bytes = std::make_shared<const FileBytes>(
        ReadFileBytes(path, loc, {limit, isNamedByScene, "; move large meshes to PLY files"}));
    if (path.ends_with(".gz") && !bytes->wasZipped)
        throw SceneError(loc, fmt::format("{}: the name ends in .gz, but this is no gzip data", path));
    std::error_code ignored;
    Source source{path, bytes->View(), std::filesystem::weakly_canonical(path, ignored).string(), bytes};
    if (source.key.empty()) source.key = path;
    RejectOtherThanText(source);
    return source;
}

}  // namespace lacquer
