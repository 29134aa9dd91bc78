#include "pbrt/image/tiled_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <span>
#include <utility>

#include "pbrt/core/hash_bytes.h"
#include "pbrt/core/output_file.h"

namespace lacquer {

namespace {

/// One entry of a TIFF directory. Values of up to eight bytes are in the entry, others elsewhere in the file.
struct Entry {
    enum class Type : uint16_t { Text = 2, Short = 3, Long = 4, Long8 = 16 };
    uint16_t tag;
    Type type;
    uint64_t count;
    uint64_t value;  ///< or its place in the file
};

/// Numbers as bytes, in the order of the machine (which the header tells).
class ByteStream {
  public:
    template <class T>
    void Put(T value) {
        const auto bytes = std::bit_cast<std::array<uint8_t, sizeof(T)>>(value);
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    void PutText(const std::string& text) {
        bytes_.insert(bytes_.end(), text.begin(), text.end());
        bytes_.push_back(0);
    }
    void PadTo(uint64_t size) { bytes_.resize(size_t(size)); }
    std::vector<uint8_t>& Bytes() { return bytes_; }

  private:
    std::vector<uint8_t> bytes_;
};

/// Values of an entry: one number of 32 bits, or up to four of 16.
uint64_t Long(uint32_t value) { return std::bit_cast<uint64_t>(std::array<uint32_t, 2>{value, 0}); }
uint64_t Shorts(uint16_t value, int count = 1) {
    std::array<uint16_t, 4> values{};
    std::fill_n(values.begin(), count, value);
    return std::bit_cast<uint64_t>(values);
}

constexpr uint64_t kHeaderBytes = 16, kPageBytes = 4096;
/// Bytes of a directory without the values behind it: a count, at most 15 entries, the place of the next.
constexpr uint64_t kEntriesBytes = 8 + 15 * 20 + 8;
/// OpenImageIO takes the images of a file with this text in PixarTextureFormat for the levels of a pyramid.
const std::string kTextureFormat = "Plain Texture";

uint64_t RoundUp(uint64_t bytes, uint64_t step) { return (bytes + step - 1) / step * step; }

/// Ends a file. Libraries that read TIFF trust what a head says, up to the end of the process.
struct Trailer {
    uint64_t headBytes, headHash;
    bool operator==(const Trailer&) const = default;
};
Trailer TrailerOf(std::span<const uint8_t> head) {
    return {head.size(), HashOfBytes({reinterpret_cast<const char*>(head.data()), head.size()})};
}
/// Larger than that of any image that can be read: 16 bytes for each tile.
constexpr uint64_t kLargestHead = uint64_t(64) << 20;

uint64_t DirectoryBytes(uint64_t numTiles, size_t descriptionBytes) {
    return RoundUp(kEntriesBytes + 16 * numTiles + kTextureFormat.size() + 1 + descriptionBytes + 1, 8);
}

/// Gathers rows to rows of tiles.
class TileWriter final : public PyramidSink {
  public:
    TileWriter(const TiledLayout& layout, OutputFile& file) : layout_(layout), file_(file) {
        for (int level = 0; level < layout.NumLevels(); ++level)
            bands_.emplace_back(size_t(layout.NumTiles(level).x) * layout.TileBytes());
    }

    void TakeRow(int level, int y, const uint8_t* texels) override {
        std::vector<uint8_t>& band = bands_[size_t(level)];
        const Int2 resolution = layout_.Resolution(level), tiles = layout_.NumTiles(level);
        const size_t texelBytes = layout_.Format().TexelBytes(), tileRow = kTileSize * texelBytes;
        for (int tile = 0; tile < tiles.x; ++tile) {
            const int width = std::min(kTileSize, resolution.x - tile * kTileSize);
            std::memcpy(&band[size_t(tile) * layout_.TileBytes() + size_t(y % kTileSize) * tileRow],
                        texels + size_t(tile) * tileRow, size_t(width) * texelBytes);
        }
        const bool isFull = y % kTileSize == kTileSize - 1 || y == resolution.y - 1;
        if (isFull) file_.WriteAt(layout_.TilesBegin(level) + uint64_t(y / kTileSize) * band.size(), band);
    }

  private:
    const TiledLayout& layout_;
    OutputFile& file_;
    std::vector<std::vector<uint8_t>> bands_;  // one row of tiles for each level
};

}  // namespace

TiledLayout::TiledLayout(Int2 image, const TexelFormat& format, std::string description)
    : levels_(PyramidLevels(image)), format_(format), description_(std::move(description)) {
    uint64_t at = kHeaderBytes;
    for (int level = 0; level < NumLevels(); ++level) {
        directoryBegin_.push_back(at);
        const Int2 tiles = NumTiles(level);
        at += DirectoryBytes(uint64_t(tiles.x) * uint64_t(tiles.y), description_.size());
    }
    at = RoundUp(at, kPageBytes);
    for (int level = 0; level < NumLevels(); ++level) {
        tilesBegin_.push_back(at);
        at += uint64_t(NumTiles(level).x) * uint64_t(NumTiles(level).y) * TileBytes();
    }
    fileBytes_ = at + sizeof(Trailer);
}

/// Entries of a level's directory, in the order of their tags, and the values that do not fit into them.
std::vector<uint8_t> TiledLayout::Directory(int level) const {
    const uint64_t numTiles = uint64_t(NumTiles(level).x) * uint64_t(NumTiles(level).y);
    const auto channels = uint16_t(format_.numChannels);
    const uint16_t kind = format_.format == PixelFormat::Byte ? 1 : 3;  // unsigned, or IEEE floats
    // The longer values follow the entries.
    const uint64_t offsets = directoryBegin_[size_t(level)] + kEntriesBytes, sizes = offsets + 8 * numTiles;
    const uint64_t texture = sizes + 8 * numTiles, text = texture + kTextureFormat.size() + 1;
    std::vector<Entry> entries = {
        {254, Entry::Type::Long, 1, Long(level > 0)},  // a smaller version of another image
        {256, Entry::Type::Long, 1, Long(uint32_t(Resolution(level).x))},
        {257, Entry::Type::Long, 1, Long(uint32_t(Resolution(level).y))},
        {258, Entry::Type::Short, channels, Shorts(uint16_t(8 * format_.ValueBytes()), channels)},
        {259, Entry::Type::Short, 1, Shorts(1)},                      // no compression
        {262, Entry::Type::Short, 1, Shorts(channels >= 3 ? 2 : 1)},  // colours or greys
        {270, Entry::Type::Text, description_.size() + 1, text},
        {277, Entry::Type::Short, 1, Shorts(channels)},
        {322, Entry::Type::Long, 1, Long(kTileSize)},
        {323, Entry::Type::Long, 1, Long(kTileSize)},
        {324, Entry::Type::Long8, numTiles, numTiles == 1 ? TilesBegin(level) : offsets},
        {325, Entry::Type::Long8, numTiles, numTiles == 1 ? TileBytes() : sizes},
        {339, Entry::Type::Short, channels, Shorts(kind, channels)},
        {33302, Entry::Type::Text, kTextureFormat.size() + 1, texture},
    };
    // A fourth channel of no stated meaning: readers leave it alone.
    if (channels == 4) entries.insert(entries.end() - 2, {338, Entry::Type::Short, 1, Shorts(0)});

    ByteStream out;
    out.Put(uint64_t(entries.size()));
    for (const Entry& e : entries) {
        out.Put(e.tag);
        out.Put(e.type);
        out.Put(e.count);
        out.Put(e.value);
    }
    const bool isLast = level + 1 == NumLevels();
    out.Put(isLast ? uint64_t(0) : directoryBegin_[size_t(level) + 1]);
    out.PadTo(kEntriesBytes);
    for (uint64_t i = 0; i < numTiles; ++i) out.Put(TilesBegin(level) + i * TileBytes());
    for (uint64_t i = 0; i < numTiles; ++i) out.Put(uint64_t(TileBytes()));
    out.PutText(kTextureFormat);
    out.PutText(description_);
    return std::move(out.Bytes());
}

std::vector<uint8_t> TiledLayout::Head() const {
    ByteStream out;
    const char order = std::endian::native == std::endian::little ? 'I' : 'M';
    out.Put(order);
    out.Put(order);
    out.Put(uint16_t(43));  // a TIFF file with places of 64 bits
    out.Put(uint16_t(8));
    out.Put(uint16_t(0));
    out.Put(directoryBegin_[0]);
    std::vector<uint8_t> head = std::move(out.Bytes());
    for (int level = 0; level < NumLevels(); ++level) {
        head.resize(size_t(directoryBegin_[size_t(level)]));
        const std::vector<uint8_t> directory = Directory(level);
        head.insert(head.end(), directory.begin(), directory.end());
    }
    head.resize(size_t(tilesBegin_[0]));
    return head;
}

void WriteTiledFile(const std::string& path, const TiledLayout& layout, PyramidSource& source,
                    WrapMode wrap) {
    OutputFile file(path);
    file.Reserve(layout.FileBytes());
    TileWriter writer(layout, file);
    MakePyramid(source, layout.Format(), wrap, writer);
    const std::vector<uint8_t> head = layout.Head();
    const auto trailer = std::bit_cast<std::array<uint8_t, sizeof(Trailer)>>(TrailerOf(head));
    file.WriteAt(0, head);
    file.WriteAt(layout.FileBytes() - trailer.size(), trailer);
    file.Finish();
}

bool HasWholeHead(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    Trailer trailer;
    if (!file.seekg(-std::streamoff(sizeof trailer), std::ios::end) ||
        !file.read(reinterpret_cast<char*>(&trailer), sizeof trailer) || trailer.headBytes > kLargestHead)
        return false;
    std::vector<uint8_t> head(trailer.headBytes);
    file.seekg(0);
    return file.read(reinterpret_cast<char*>(head.data()), std::streamsize(head.size())) &&
           TrailerOf(head) == trailer;
}

}  // namespace lacquer
