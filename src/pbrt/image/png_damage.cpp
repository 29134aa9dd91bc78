// Names, sizes and order of chunks are those of the PNG specification [W3C, "Portable Network Graphics", 2nd
// ed.].
#include "pbrt/image/png_damage.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <vector>

namespace lacquer {

namespace {

constexpr const char* kTooShort = "the PNG data end too early";

uint32_t BigEndian(const unsigned char* bytes) {
    return (uint32_t(bytes[0]) << 24) | (uint32_t(bytes[1]) << 16) | (uint32_t(bytes[2]) << 8) | bytes[3];
}

/// The chunks of a file, one after the other.
class Chunks {
  public:
    explicit Chunks(const std::string& path) : file_(path, std::ios::binary) { file_.seekg(8); }
    /// Goes to the next chunk; false at the file's end.
    bool Next() {
        unsigned char head[8];
        if (!Read(head, 8)) return false;
        length_ = left_ = BigEndian(head);
        name_.assign(reinterpret_cast<const char*>(head) + 4, 4);
        checksum_ = crc32(0, head + 4, 4);
        return true;
    }
    const std::string& Name() const { return name_; }
    uint32_t Length() const { return length_; }
    bool HasValidName() const {
        return std::all_of(name_.begin(), name_.end(),
                           [](unsigned char c) { return c < 0x80 && std::isalpha(c); });
    }
    bool IsCritical() const { return std::isupper(static_cast<unsigned char>(name_[0])) != 0; }
    /// The next bytes of the chunk, at most 64 KiB; empty at its end, or if the file ends before.
    const std::vector<unsigned char>& More() {
        buffer_.resize(std::min<size_t>(left_, 1 << 16));
        if (!Read(buffer_.data(), buffer_.size())) buffer_.clear();
        left_ -= uint32_t(buffer_.size());
        checksum_ = crc32(checksum_, buffer_.data(), uInt(buffer_.size()));
        return buffer_;
    }
    /// Skips what is left of the chunk; false if the file ends before.
    bool Finish() {
        while (!More().empty()) {
        }
        unsigned char stored[4];
        if (left_ > 0 || !Read(stored, 4)) return false;
        isSound_ = checksum_ == BigEndian(stored);
        return true;
    }
    /// After Finish().
    bool IsSound() const { return isSound_; }

  private:
    bool Read(unsigned char* bytes, size_t count) {
        return count == 0 || file_.read(reinterpret_cast<char*>(bytes), std::streamsize(count));
    }
    std::ifstream file_;
    std::string name_;
    uint32_t length_ = 0, left_ = 0;
    uLong checksum_ = 0;
    bool isSound_ = false;
    std::vector<unsigned char> buffer_;
};

struct Header {
    uint32_t width = 0, height = 0;
    int bitDepth = 0, colorType = 0, compression = 0, filter = 0, interlace = 0;

    static constexpr uint32_t kBytes = 13;
    explicit Header(const std::vector<unsigned char>& data)
        : width(BigEndian(data.data())),
          height(BigEndian(data.data() + 4)),
          bitDepth(data[8]),
          colorType(data[9]),
          compression(data[10]),
          filter(data[11]),
          interlace(data[12]) {}
    int NumChannels() const { return colorType == 2 ? 3 : colorType == 4 ? 2 : colorType == 6 ? 4 : 1; }
    bool IsPalette() const { return colorType == 3; }
    bool HasValidDepth() const {
        if (bitDepth == 8) return true;
        if (bitDepth == 16) return !IsPalette();
        return (bitDepth == 1 || bitDepth == 2 || bitDepth == 4) && (colorType == 0 || IsPalette());
    }
};

std::string HeaderDamage(const Header& h) {
    // libpng refuses more pixels a side.
    constexpr uint32_t kMaxSide = 1000000;
    if (h.width == 0 || h.height == 0 || h.width > kMaxSide || h.height > kMaxSide)
        return fmt::format("the PNG header claims {} x {} pixels", h.width, h.height);
    const bool isKnownType = h.colorType <= 6 && h.colorType != 1 && h.colorType != 5;
    if (!isKnownType || !h.HasValidDepth())
        return fmt::format("the PNG header claims {} bits in colour type {}, which does not exist",
                           h.bitDepth, h.colorType);
    if (h.compression != 0 || h.filter != 0 || h.interlace > 1)
        return "the PNG header asks for a compression, filter or interlacing that does not exist";
    return "";
}

/// The most bytes that one chunk may have, as libpng sees it: 8 MB, or what stored blocks with all pixels
/// take.
uint64_t MaxChunkBytes(const std::string& name, const Header& h) {
    constexpr uint64_t kUsual = 8000000, kMax = 0x7fffffff, kBlock = 32566, kBlockHead = 5, kFrame = 6;
    if (name != "IDAT") return kUsual;
    const uint64_t row =
        uint64_t(h.width) * uint64_t(h.NumChannels()) * (h.bitDepth > 8 ? 2 : 1) + 1 + (h.interlace ? 6 : 0);
    const uint64_t pixels = h.height > kMax / row ? kMax : h.height * row;
    return std::clamp(pixels + kFrame + kBlockHead * (pixels / std::min(row, kBlock) + 1), kUsual, kMax);
}

std::string PaletteDamage(uint32_t bytes, const Header& h) {
    const bool mayHaveOne = h.colorType != 0 && h.colorType != 4;
    const bool isValid = bytes > 0 && bytes <= 3 * 256 && bytes % 3 == 0;
    return mayHaveOne && !isValid ? fmt::format("the PNG palette has {} bytes", bytes) : "";
}

/// Checks the order of chunks that must be understood.
class ChunkOrder {
  public:
    std::string Damage(const Chunks& chunk, const Header& header) {
        const std::string& name = chunk.Name();
        if (name == "IHDR") return "a second PNG header";
        if (name == "PLTE") {
            if (hasPalette_) return "a second PNG palette";
            hasPalette_ = true;
            return PaletteDamage(chunk.Length(), header);
        }
        if (name == "IDAT") {
            hasPixels_ = true;
            return header.IsPalette() && !hasPalette_ ? "the PNG palette is missing" : "";
        }
        if (name == "IEND") return hasPixels_ ? "" : "the PNG file has no pixels";
        return chunk.IsCritical() ? "a PNG chunk that no specification knows" : "";
    }

  private:
    bool hasPalette_ = false, hasPixels_ = false;
};

/// Follows the unpacked bytes of all rows: each begins with the number of its filter.
class Rows {
  public:
    explicit Rows(const Header& h) {
        struct Pass {
            uint32_t x, y, stepX, stepY;
        };
        // The seven passes of interlaced files; other files have one.
        constexpr std::array<Pass, 7> kPasses = {{{0, 0, 8, 8},
                                                  {4, 0, 8, 8},
                                                  {0, 4, 4, 8},
                                                  {2, 0, 4, 4},
                                                  {0, 2, 2, 4},
                                                  {1, 0, 2, 2},
                                                  {0, 1, 1, 2}}};
        const auto add = [&](const Pass& p) {
            if (h.width <= p.x || h.height <= p.y) return;
            const uint64_t columns = (h.width - p.x + p.stepX - 1) / p.stepX;
            const uint64_t rows = (h.height - p.y + p.stepY - 1) / p.stepY;
            const uint64_t bits = columns * uint64_t(h.NumChannels()) * uint64_t(h.bitDepth);
            passes_.push_back({1 + (bits + 7) / 8, rows});
        };
        if (h.interlace)
            for (const Pass& p : kPasses) add(p);
        else
            add({0, 0, 1, 1});
    }
    bool AreComplete() const { return pass_ == passes_.size(); }
    bool HaveValidFilters() const { return isValid_; }
    /// libpng lets a few surplus bytes pass. It unpacks all of them, so they must not be many.
    bool HaveFewSurplusBytes() const { return surplus_ <= 65536; }
    void Take(const unsigned char* bytes, size_t count) {
        constexpr unsigned char kLastFilter = 4;
        size_t at = 0;
        while (at < count && !AreComplete()) {
            const Group& group = passes_[pass_];
            if (inRow_ == 0 && bytes[at] > kLastFilter) isValid_ = false;
            const size_t step = size_t(std::min<uint64_t>(group.rowBytes - inRow_, count - at));
            at += step;
            inRow_ += step;
            if (inRow_ < group.rowBytes) continue;
            inRow_ = 0;
            if (++row_ < group.numRows) continue;
            row_ = 0;
            ++pass_;
        }
        surplus_ += count - at;
    }

  private:
    struct Group {
        uint64_t rowBytes, numRows;
    };
    std::vector<Group> passes_;
    size_t pass_ = 0;
    uint64_t row_ = 0, inRow_ = 0, surplus_ = 0;
    bool isValid_ = true;
};

// zlib's stream, freed whatever happens.
struct Inflater {
    // With the window that the data ask for, as in libpng.
    Inflater() { ok = inflateInit2(&stream, 0) == Z_OK; }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    z_stream stream{};
    bool ok;
};

/// Unpacks `packed`, a part of the pixels; zlib's result, Z_OK while it wants more.
int Unpack(const std::vector<unsigned char>& packed, Inflater& inflater, Rows* rows) {
    std::array<unsigned char, 1 << 15> unpacked;
    z_stream& stream = inflater.stream;
    stream.next_in = const_cast<unsigned char*>(packed.data());
    stream.avail_in = uInt(packed.size());
    int result = Z_OK;
    do {
        stream.next_out = unpacked.data();
        stream.avail_out = uInt(unpacked.size());
        result = inflate(&stream, Z_NO_FLUSH);
        rows->Take(unpacked.data(), unpacked.size() - stream.avail_out);
    } while (result == Z_OK && stream.avail_out == 0 && rows->HaveFewSurplusBytes());
    // No progress for want of input is no error.
    return result == Z_BUF_ERROR ? Z_OK : result;
}

}  // namespace

std::string PngChunkDamage(const std::string& path) {
    Chunks chunks(path);
    if (!chunks.Next()) return kTooShort;
    if (chunks.Name() != "IHDR" || chunks.Length() != Header::kBytes)
        return "the PNG header is not the first chunk";
    const std::vector<unsigned char> data = chunks.More();
    if (!chunks.Finish()) return kTooShort;
    if (!chunks.IsSound()) return "a PNG chunk has a wrong checksum";
    const Header header(data);
    if (std::string damage = HeaderDamage(header); !damage.empty()) return damage;

    ChunkOrder order;
    while (chunks.Next()) {
        if (!chunks.HasValidName()) return "a PNG chunk has an impossible name";
        if (chunks.Length() > MaxChunkBytes(chunks.Name(), header)) return "a PNG chunk is too large";
        if (std::string damage = order.Damage(chunks, header); !damage.empty()) return damage;
        if (!chunks.Finish()) return kTooShort;
        if (chunks.IsCritical() && !chunks.IsSound()) return "a PNG chunk has a wrong checksum";
        if (chunks.Name() == "IEND") return "";
    }
    return kTooShort;
}

std::string PngPixelDamage(const std::string& path) {
    Chunks chunks(path);
    if (!chunks.Next()) return kTooShort;
    const std::vector<unsigned char> data = chunks.More();
    if (data.size() != Header::kBytes || !chunks.Finish()) return kTooShort;
    Rows rows{Header(data)};
    Inflater inflater;
    int result = inflater.ok ? Z_OK : Z_MEM_ERROR;
    // The pixels are in one chunk, or in several in a row.
    bool begun = false;
    while (result == Z_OK && chunks.Next()) {
        const bool hasPixels = chunks.Name() == "IDAT";
        if (begun && !hasPixels) break;
        begun = hasPixels;
        while (hasPixels && result == Z_OK && rows.HaveFewSurplusBytes()) {
            const std::vector<unsigned char>& packed = chunks.More();
            if (packed.empty()) break;
            result = Unpack(packed, inflater, &rows);
        }
        if (!chunks.Finish() || !rows.HaveFewSurplusBytes()) break;
    }
    if (result != Z_OK && result != Z_STREAM_END) return "the compressed PNG data make no sense";
    if (!rows.HaveValidFilters()) return "a row of the PNG file has an unknown filter";
    if (!rows.HaveFewSurplusBytes()) return "the PNG data go on after the last row";
    return result == Z_STREAM_END && rows.AreComplete() ? "" : kTooShort;
}

}  // namespace lacquer
