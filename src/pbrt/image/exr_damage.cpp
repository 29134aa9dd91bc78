#include "pbrt/image/exr_damage.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace lacquer {

namespace {

/// Bytes of types whose values all have the same size (OpenEXR File Layout, "Predefined Attribute Types").
constexpr std::pair<std::string_view, uint64_t> kFixedSizes[] = {
    {"box2f", 16},
    {"box2i", 16},
    {"chromaticities", 32},
    {"compression", 1},
    {"deepImageState", 1},
    {"double", 8},
    {"envmap", 1},
    {"float", 4},
    {"int", 4},
    {"keycode", 28},
    {"lineOrder", 1},
    {"m33d", 72},
    {"m33f", 36},
    {"m44d", 128},
    {"m44f", 64},
    {"rational", 8},
    {"tiledesc", 9},
    {"timecode", 8},
    {"v2d", 16},
    {"v2f", 8},
    {"v2i", 8},
    {"v3d", 24},
    {"v3f", 12},
    {"v3i", 12},
};
/// Of names and types: the library gives up at the same length.
constexpr size_t kMaxNameBytes = 255;

/// A file of known length, read forward. What does not fit makes it bad, as a stream.
class Cursor {
  public:
    explicit Cursor(const std::string& path) : file_(path, std::ios::binary | std::ios::ate) {
        end_ = uint64_t(std::max<std::streamoff>(file_.tellg(), 0));
        file_.seekg(0);
    }

    explicit operator bool() const { return bool(file_); }
    uint64_t Position() const { return position_; }
    uint64_t Left() const { return end_ - std::min(end_, position_); }
    void Skip(uint64_t bytes) {
        constexpr uint64_t kShort = 4096;  // a seek forgets what has been read ahead
        if (bytes > Left())
            file_.setstate(std::ios::failbit);
        else if (bytes <= kShort)
            file_.ignore(std::streamsize(bytes));
        else
            file_.seekg(std::streamoff(bytes), std::ios::cur);
        position_ += bytes;
    }

    /// Little-endian.
    uint32_t Word() {
        std::array<unsigned char, 4> b{};
        file_.read(reinterpret_cast<char*>(b.data()), b.size());
        position_ += b.size();
        return b[0] | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
    }
    /// Up to a zero byte; bad if that does not come in time.
    std::string Name() {
        std::string name;
        for (char c; file_.get(c);) {
            ++position_;
            if (c == '\0') return name;
            name += c;
            if (name.size() > kMaxNameBytes) break;
        }
        file_.setstate(std::ios::failbit);
        return name;
    }

  private:
    std::ifstream file_;
    uint64_t end_ = 0, position_ = 0;
};

// ---- Where the values of a type end: beyond `end` if they do not fit ----

void SkipChannels(Cursor& file) {
    constexpr uint64_t kChannelBytes = 16;  // pixel type, linearity and sampling rates
    while (!file.Name().empty() && file) file.Skip(kChannelBytes);
}

void SkipPreview(Cursor& file) {
    const uint64_t width = file.Word(), height = file.Word();
    file.Skip(4 * std::min(width * height, uint64_t(1) << 40));
}

void SkipTexts(Cursor& file, uint64_t end) {
    while (file && file.Position() < end) file.Skip(file.Word());
}

/// Says what does not fit; empty if all does. Leaves the file where the values end.
std::string ValueDamage(Cursor& file, const std::string& name, std::string_view type, uint64_t bytes) {
    const uint64_t end = file.Position() + bytes;
    // Even its own: the library (3.1.5) takes eight bytes for a length that it counts as four.
    if (type == "idmanifest")
        return fmt::format(
            "attribute \"{}\" is an ID manifest, of which OpenEXR reads four bytes too many; "
            "without it the file can be read",
            name);
    const auto fixed = std::ranges::find(kFixedSizes, type, &std::pair<std::string_view, uint64_t>::first);
    if (fixed != std::end(kFixedSizes)) {
        file.Skip(fixed->second);
    } else if (type == "chlist") {
        SkipChannels(file);
    } else if (type == "preview") {
        SkipPreview(file);
    } else if (type == "stringvector") {
        SkipTexts(file, end);
    } else if (type == "floatvector") {
        file.Skip(bytes - bytes % sizeof(float));
    } else {
        file.Skip(bytes);  // of any length, or of a type that the library skips as well
    }
    if (file && file.Position() == end) return "";
    return fmt::format("attribute \"{}\" of type \"{}\" does not end where the EXR header says", name, type);
}

}  // namespace

std::string ExrHeaderDamage(const std::string& path) {
    constexpr uint32_t kMultipart = 0x1000;  // of the version's flags
    Cursor file(path);
    file.Skip(4);
    const bool isMultipart = file.Word() & kMultipart;
    // Each header ends with an empty name; several headers end with an empty one.
    for (bool headerIsEmpty = true; file;) {
        const std::string name = file.Name();
        if (!file) break;
        if (name.empty() && (!isMultipart || headerIsEmpty)) return "";
        headerIsEmpty = name.empty();
        if (name.empty()) continue;
        const std::string type = file.Name();
        const uint64_t bytes = file.Word();
        if (!file) break;
        if (bytes > file.Left()) return "an attribute of the EXR header is larger than the file";
        if (std::string damage = ValueDamage(file, name, type, bytes); !damage.empty()) return damage;
    }
    return "the EXR header ends too early";
}

}  // namespace lacquer
