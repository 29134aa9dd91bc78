#include "pbrt/film/state_file.h"

#include <blosc.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <utility>

#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/output_file.h"
#include "pbrt/core/parallel.h"

namespace lacquer {
namespace {

namespace fs = std::filesystem;

// The file: kMagic; the header; of each array its name, a number for its kind, its sizes in bytes and its
// blocks; kEnd. Texts have their length before them and a checksum behind, blocks the lengths they have
// packed and unpacked, and a checksum. Numbers have 64 bits.
constexpr std::string_view kBeginning = "lacquer-state ", kMagic = "lacquer-state 2\n",
                           kEnd = "end of lacquer-state\n";
constexpr size_t kBlock = size_t(1) << 20, kBlocksAtOnce = 64;
/// The least effort: more of it takes twice the time for next to nothing.
constexpr int kEffort = 1;

/// Blocks are packed to at least this part of them, so that a short file cannot ask for much memory.
constexpr size_t kMaxRatio = 1000;

using Bytes = std::vector<unsigned char>;

uint64_t ChecksumOf(std::span<const unsigned char> bytes) {
    return crc32_z(crc32_z(0, nullptr, 0), bytes.data(), bytes.size());
}

/// What Blosc packs with: the first one that it was built with. Blocks say which it was.
const char* Codec() {
    static const char* const codec = [] {
        for (const char* name : {BLOSC_ZSTD_COMPNAME, BLOSC_LZ4_COMPNAME})
            if (blosc_compname_to_compcode(name) >= 0) return name;
        return BLOSC_BLOSCLZ_COMPNAME;
    }();
    return codec;
}

/// Sorted by the places of the bytes in their elements first: bytes that hardly change stand together.
Bytes Packed(std::span<const unsigned char> block, size_t width) {
    Bytes packed(block.size() + BLOSC_MAX_OVERHEAD);
    const int size = blosc_compress_ctx(kEffort, BLOSC_SHUFFLE, width, block.size(), block.data(),
                                        packed.data(), packed.size(), Codec(), 0, 1);
    LACQUER_CHECK(size > 0);
    packed.resize(std::max(size_t(size), block.size() / kMaxRatio));
    return packed;
}

/// False for what is no such block of `block.size()` bytes.
bool Unpack(std::span<const unsigned char> packed, std::span<unsigned char> block) {
    if (packed.size() < BLOSC_MIN_HEADER_LENGTH) return false;
    size_t size = 0, packedSize = 0, ignored = 0;
    blosc_cbuffer_sizes(packed.data(), &ignored, &packedSize, &ignored);  // less what Packed() has appended
    return packedSize <= packed.size() && blosc_cbuffer_validate(packed.data(), packedSize, &size) == 0 &&
           size == block.size() &&
           blosc_decompress_ctx(packed.data(), block.data(), block.size(), 1) == int(block.size());
}

/// A sequence of bytes of a state, and the width of its elements.
struct Section {
    std::span<unsigned char> bytes;
    size_t width;
};

template <class T>
std::span<unsigned char> BytesOf(std::vector<T>& values) {
    return {reinterpret_cast<unsigned char*>(values.data()), values.size() * sizeof(T)};
}

/// Writes the parts of a state to whatever takes bytes.
class StateWriter {
  public:
    using Sink = std::function<void(std::span<const unsigned char>)>;
    explicit StateWriter(Sink sink) : sink_(std::move(sink)) {}

    void All(const std::string& header, const std::vector<StateArray>& arrays) {
        Magic(kMagic);
        Text(header);
        Number(arrays.size());
        for (const StateArray& array : arrays) Array(array);
        Magic(kEnd);
    }

  private:
    void Array(const StateArray& array) {
        Text(array.name);
        Number(array.values.index());
        if (ExactSums* const* sums = std::get_if<ExactSums*>(&array.values)) {
            Write({(*sums)->BinBytes(), sizeof(int64_t)});
            Write({(*sums)->LevelBytes(), 1});
        } else if (std::vector<int>* const* counts = std::get_if<std::vector<int>*>(&array.values)) {
            Write({BytesOf(**counts), sizeof(int)});
        } else {
            std::vector<int> flat = std::get<IdCounts*>(array.values)->Flat();
            Write({BytesOf(flat), sizeof(int)});
        }
    }

    void Text(std::string_view text) {
        Number(text.size());
        const std::span bytes(reinterpret_cast<const unsigned char*>(text.data()), text.size());
        Raw(bytes);
        Number(ChecksumOf(bytes));
    }
    void Number(uint64_t number) { Raw({reinterpret_cast<const unsigned char*>(&number), sizeof number}); }
    void Magic(std::string_view text) {
        Raw({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
    }
    void Write(const Section& section) {
        Number(section.bytes.size());
        for (size_t first = 0; first < section.bytes.size(); first += kBlock * kBlocksAtOnce) {
            const auto part = section.bytes.subspan(first);
            const size_t blocks = std::min(kBlocksAtOnce, (part.size() + kBlock - 1) / kBlock);
            std::vector<Bytes> packed(blocks);
            const auto block = [&](size_t i) {
                return part.subspan(i * kBlock, std::min(kBlock, part.size() - i * kBlock));
            };
            ParallelFor(int64_t(blocks),
                        [&](int64_t i) { packed[size_t(i)] = Packed(block(size_t(i)), section.width); });
            for (size_t i = 0; i < blocks; ++i) {
                Number(packed[i].size());
                Number(ChecksumOf(packed[i]));
                Raw(packed[i]);
            }
        }
    }
    void Raw(std::span<const unsigned char> bytes) { sink_(bytes); }

    Sink sink_;
};

/// By a second name, so that there is a whole state at `path` at any time.
void KeepPrevious(const std::string& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return;
    const std::string previous = PreviousState(path);
    fs::remove(previous, error);
    if (!error) fs::create_hard_link(fs::canonical(path), previous, error);
    if (error) fs::rename(path, previous, error);  // no links on this file system
    if (error) throw FileError(previous, "cannot be replaced: " + error.message());
}

/// So that new names in the folder of `path` survive a loss of power; file systems that cannot do so say so.
void SyncFolderOf(const std::string& path) {
    const fs::path folder = fs::path(path).parent_path();
    const int file = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    fsync(file);
    close(file);
}

class StateReader {
  public:
    StateReader(const std::string& path, std::string_view bytes) : path_(path), rest_(bytes) {
        if (!rest_.starts_with(kMagic))
            throw FileError(path_, rest_.starts_with(kBeginning)
                                       ? "is a state of another version of the program"
                                       : "is no state of a render (of --checkpoint)");
        rest_.remove_prefix(kMagic.size());
    }
    uint64_t Number() {
        uint64_t number = 0;
        std::memcpy(&number, Take(sizeof number).data(), sizeof number);
        return number;
    }
    std::string Text() {
        const auto bytes = Take(Number());
        if (Number() != ChecksumOf(bytes)) Fail();
        return {bytes.begin(), bytes.end()};
    }
    void Read(const Section& section) {
        const size_t blocks = (section.bytes.size() + kBlock - 1) / kBlock;
        std::vector<std::span<const unsigned char>> packed;
        std::vector<uint64_t> checksums;
        for (size_t i = 0; i < blocks; ++i) {
            const uint64_t size = Number();
            checksums.push_back(Number());
            packed.push_back(Take(size));
        }
        std::atomic<bool> isDamaged = false;
        ParallelFor(int64_t(blocks), [&](int64_t i) {
            const size_t begin = size_t(i) * kBlock;
            const auto block = section.bytes.subspan(begin, std::min(kBlock, section.bytes.size() - begin));
            const auto& from = packed[size_t(i)];
            if (ChecksumOf(from) != checksums[size_t(i)] || !Unpack(from, block)) isDamaged = true;
        });
        if (isDamaged) Fail();
    }
    /// A length that its packed blocks can have.
    size_t Length(size_t multipleOf) {
        const uint64_t length = Number();
        if (length % multipleOf != 0 || length / kMaxRatio > rest_.size() + kMaxRatio) Fail();
        return size_t(length);
    }
    void End() {
        if (rest_ != kEnd) Fail();
    }
    [[noreturn]] void Fail() const {
        std::error_code error;
        const std::string previous = PreviousState(path_);
        throw FileError(path_, fs::exists(previous, error)
                                   ? fmt::format("this state is damaged; the one before it is {}", previous)
                                   : "this state is damaged");
    }

  private:
    std::span<const unsigned char> Take(uint64_t size) {
        if (size > rest_.size()) Fail();
        const std::span bytes(reinterpret_cast<const unsigned char*>(rest_.data()), size_t(size));
        rest_.remove_prefix(size_t(size));
        return bytes;
    }

    std::string path_;
    std::string_view rest_;
};

std::vector<int> ReadInts(StateReader* reader) {
    std::vector<int> values(reader->Length(sizeof(int)) / sizeof(int));
    reader->Read({BytesOf(values), sizeof(int)});
    return values;
}

StoredArray ReadArray(StateReader* reader) {
    StoredArray array{reader->Text(), {}};
    const uint64_t kind = reader->Number();
    if (kind > 2) reader->Fail();
    if (kind == 1) array.values = ReadInts(reader);
    if (kind == 2) array.values = FlatIds{ReadInts(reader)};
    if (kind != 0) return array;
    ExactSums sums(reader->Length(ExactSums::kBinBytes) / ExactSums::kBinBytes);
    reader->Read({sums.BinBytes(), sizeof(int64_t)});
    if (reader->Length(1) != sums.Size()) reader->Fail();
    reader->Read({sums.LevelBytes(), 1});
    if (!sums.HasValidLevels()) reader->Fail();
    array.values = std::move(sums);
    return array;
}

constexpr size_t kMaxFile = size_t(64) << 30;

}  // namespace

std::string PreviousState(const std::string& path) { return path + ".previous"; }

void WriteStateFile(const std::string& path, const std::string& header,
                    const std::vector<StateArray>& arrays) {
    OutputFile file(path);
    StateWriter([&](std::span<const unsigned char> bytes) { file.Write(bytes); }).All(header, arrays);
    file.Sync();
    KeepPrevious(path);
    file.Finish();
    SyncFolderOf(path);
}

std::vector<unsigned char> StateBytes(const std::string& header, const std::vector<StateArray>& arrays) {
    std::vector<unsigned char> all;
    StateWriter([&](std::span<const unsigned char> bytes) {
        all.insert(all.end(), bytes.begin(), bytes.end());
    }).All(header, arrays);
    return all;
}

StateFile ReadStateFile(const std::string& path) {
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = kMaxFile});
    const std::string_view view = bytes.View();
    return ReadState(path, {reinterpret_cast<const unsigned char*>(view.data()), view.size()});
}

StateFile ReadState(const std::string& name, std::span<const unsigned char> bytes) {
    StateReader reader(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    StateFile file;
    file.header = reader.Text();
    const uint64_t count = reader.Number();
    for (uint64_t i = 0; i < count; ++i) file.arrays.push_back(ReadArray(&reader));
    reader.End();
    return file;
}

bool IsStateFile(const std::string& path) {
    std::error_code error;
    return fs::is_regular_file(path, error) && access(path.c_str(), R_OK) == 0 &&
           ReadFirstBytes(path, {}, kBeginning.size()) == kBeginning;
}

std::string ReadStateHeader(const std::string& path) {
    uint64_t length = 0;
    const std::string start = ReadFirstBytes(path, {}, kMagic.size() + sizeof length);
    // A file that is none of ours, or ends too soon, has no length; the reader says what it is.
    if (start.starts_with(kMagic) && start.size() == kMagic.size() + sizeof length)
        std::memcpy(&length, &start[kMagic.size()], sizeof length);
    const size_t whole = start.size() + size_t(std::min<uint64_t>(length, kMaxFile)) + sizeof(uint64_t);
    return StateReader(path, ReadFirstBytes(path, {}, whole)).Text();
}

}  // namespace lacquer
