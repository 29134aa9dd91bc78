#include "pbrt/media/nanovdb_file.h"

#include <blosc.h>
#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <set>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#include <nanovdb/util/IO.h>
#pragma GCC diagnostic pop

namespace lacquer {

namespace {

using nanovdb::GridData;
using Tree = nanovdb::TreeData<3>;
using Root = nanovdb::NanoRoot<float>::DataType;
using Upper = nanovdb::NanoUpper<float>::DataType;
using Lower = nanovdb::NanoLower<float>::DataType;
using Leaf = nanovdb::NanoLeaf<float>::DataType;
using Source = SparseGrid::Source;

/// Memory of a grid, aligned as its nodes want.
struct FreeAligned {
    void operator()(char* p) const { std::free(p); }
};
struct GridBytes {
    std::unique_ptr<char, FreeAligned> data;
    size_t size = 0;
};

/// What is wrong with a grid; the file adds its name and place.
struct Damage {
    std::string problem;
};
[[noreturn]] void FailDamaged(const std::string& problem) { throw Damage{problem}; }

/// Memory for `size` bytes that `numPacked` bytes are said to unpack to.
GridBytes Allocate(uint64_t size, size_t numPacked, uint64_t largestRatio) {
    if (size < sizeof(GridData) + sizeof(Tree) + sizeof(Root) || size / largestRatio > numPacked)
        FailDamaged(fmt::format("{} bytes cannot hold a grid of {} bytes", numPacked, size));
    GridBytes bytes;
    bytes.size = size_t(size);
    const size_t rounded =
        (bytes.size + NANOVDB_DATA_ALIGNMENT - 1) / NANOVDB_DATA_ALIGNMENT * NANOVDB_DATA_ALIGNMENT;
    bytes.data.reset(static_cast<char*>(std::aligned_alloc(NANOVDB_DATA_ALIGNMENT, rounded)));
    if (!bytes.data) FailDamaged(fmt::format("no memory for its {} bytes", size));
    return bytes;
}

uint64_t TakeSize(std::string_view* packed) {
    uint64_t size = 0;
    if (packed->size() < sizeof size) FailDamaged("its packed data ends early");
    std::memcpy(&size, packed->data(), sizeof size);
    packed->remove_prefix(sizeof size);
    if (size > packed->size()) FailDamaged("its packed data ends early");
    return size;
}

GridBytes Unzip(std::string_view packed, uint64_t size) {
    const uint64_t numPacked = TakeSize(&packed);
    GridBytes bytes = Allocate(size, packed.size(), 1040);  // DEFLATE packs 1032 to one at most
    uLongf numUnpacked = bytes.size;
    if (uncompress(reinterpret_cast<Bytef*>(bytes.data.get()), &numUnpacked,
                   reinterpret_cast<const Bytef*>(packed.data()), uLong(numPacked)) != Z_OK ||
        numUnpacked != bytes.size)
        FailDamaged("its zip data is damaged");
    return bytes;
}

GridBytes Unblosc(std::string_view packed, uint64_t size) {
    // Chunks of a gigabyte, each after its packed size.
    GridBytes bytes = Allocate(size, packed.size(), 1 << 16);
    for (size_t done = 0; done < bytes.size;) {
        const size_t chunk = std::min(bytes.size - done, size_t(1) << 30), numPacked = TakeSize(&packed);
        size_t numUnpacked = 0;
        if (blosc_cbuffer_validate(packed.data(), numPacked, &numUnpacked) < 0 || numUnpacked != chunk ||
            blosc_decompress_ctx(packed.data(), bytes.data.get() + done, chunk, 1) != int(chunk))
            FailDamaged("its Blosc data is damaged");
        packed.remove_prefix(numPacked);
        done += chunk;
    }
    return bytes;
}

GridBytes Unpack(std::string_view packed, uint64_t size, nanovdb::io::Codec codec) {
    if (codec == nanovdb::io::Codec::ZIP) return Unzip(packed, size);
    if (codec == nanovdb::io::Codec::BLOSC) return Unblosc(packed, size);
    GridBytes bytes = Allocate(size, packed.size(), 1);
    std::memcpy(bytes.data.get(), packed.data(), bytes.size);
    return bytes;
}

/// The nodes of a grid, each seen to lie in its memory before it is touched.
class GridNodes {
  public:
    explicit GridNodes(GridBytes* bytes) : bytes_(*bytes) {
        grid_ = At<GridData>(0, 1, "grid");
        if (grid_->mMagic != NANOVDB_MAGIC_NUMBER) FailDamaged("its grid does not begin as one");
        if (grid_->mGridType != nanovdb::GridType::Float)
            FailDamaged(fmt::format("its values are of the type {}; floats are expected",
                                    TypeName(grid_->mGridType)));
        if (grid_->mGridClass != nanovdb::GridClass::FogVolume &&
            grid_->mGridClass != nanovdb::GridClass::Unknown)
            FailDamaged("it is not a fog volume");
        tree_ = At<Tree>(sizeof(GridData), 1, "tree");
        rootOffset_ = sizeof(GridData) + tree_->mNodeOffset[3];
        root_ = At<Root>(rootOffset_, 1, "root");
        tiles_ = At<Root::Tile>(rootOffset_ + sizeof(Root), root_->mTableSize, "table of its root");
    }
    const GridData& Grid() const { return *grid_; }
    const Root& GetRoot() const { return *root_; }
    std::span<const Root::Tile> Tiles() const { return {tiles_, root_->mTableSize}; }
    Upper* ChildOf(const Root::Tile& tile) const { return Child<Upper>(rootOffset_, tile.child); }
    template <class Child_, class Node>
    Child_* ChildOf(const Node* node, uint32_t n) const {
        const auto offset = uint64_t(reinterpret_cast<const char*>(node) - bytes_.data.get());
        return Child<Child_>(offset, node->mTable[n].child);
    }

    /// Compares the checksums that the grid was written with.
    void CheckSums() const {
        const auto head = uint32_t(grid_->mChecksum), tail = uint32_t(grid_->mChecksum >> 32);
        constexpr uint32_t kNone = 0xffffffff;
        constexpr size_t kFirst = 16;  // behind magic number and checksum
        if (head == kNone || tree_->mNodeOffset[3] != sizeof(Tree)) return;
        const size_t end = rootOffset_ + sizeof(Root) + root_->mTableSize * sizeof(Root::Tile);
        if (SumOf(bytes_.data.get() + kFirst, end - kFirst) != head) FailDamaged("its checksum is wrong");
        if (tail == kNone || root_->mTableSize == 0) return;
        // One sum over those of all nodes, which the writing machine kept in four or in eight bytes each.
        std::vector<uint32_t> sums;
        AddSums<Upper>(2, &sums);
        AddSums<Lower>(1, &sums);
        AddSums<Leaf>(0, &sums);
        const std::vector<uint64_t> wide(sums.begin(), sums.end());
        if (SumOf(sums.data(), sums.size() * sizeof sums[0]) != tail &&
            SumOf(wide.data(), wide.size() * sizeof wide[0]) != tail)
            FailDamaged("the checksum of its nodes is wrong");
    }

  private:
    static std::string TypeName(nanovdb::GridType type) {
        return type < nanovdb::GridType::End ? nanovdb::toStr(type) : "?";
    }
    static uint32_t SumOf(const void* data, size_t size) {
        return uint32_t(crc32_z(0, static_cast<const Bytef*>(data), size));
    }
    template <class Node>
    void AddSums(int level, std::vector<uint32_t>* sums) const {
        const uint32_t count = tree_->mNodeCount[level];
        if (count == 0) return;
        const Node* nodes = At<Node>(sizeof(GridData) + tree_->mNodeOffset[level], count, "nodes");
        for (uint32_t i = 0; i < count; ++i) sums->push_back(SumOf(nodes + i, sizeof(Node)));
    }
    template <class Node>
    Node* Child(uint64_t from, int64_t distance) const {
        return At<Node>(from + uint64_t(distance), 1, "nodes");
    }
    /// `count` objects from an offset on.
    template <class T>
    T* At(uint64_t offset, uint64_t count, const char* what) const {
        if (offset % NANOVDB_DATA_ALIGNMENT != 0 || offset > bytes_.size ||
            count > (bytes_.size - offset) / sizeof(T))
            FailDamaged(fmt::format("its {} lie{} outside of its {} bytes", what,
                                    std::strcmp(what, "nodes") == 0 ? "" : "s", bytes_.size));
        return reinterpret_cast<T*>(bytes_.data.get() + offset);
    }

    const GridBytes& bytes_;
    const GridData* grid_;
    const Tree* tree_;
    const Root* root_;
    const Root::Tile* tiles_;
    uint64_t rootOffset_;
};

/// The blocks of a tree that lie in a box, on a regular grid.
class BlockTable {
  public:
    BlockTable(Int3 first, Int3 size, float background, bool clampNegative)
        : first_(first),
          size_(size),
          clampNegative_(clampNegative),
          sources_(size_t(size.x) * size_t(size.y) * size_t(size.z), Source{nullptr, Checked(background)}) {}

    void Add(const GridNodes& nodes) {
        std::set<uint64_t> keys;
        for (const Root::Tile& tile : nodes.Tiles()) {
            if (!keys.insert(tile.key).second) FailDamaged("two entries of its root are for the same place");
            const nanovdb::Coord origin = tile.origin();
            const Int3 block = Int3(origin[0], origin[1], origin[2]) >> 3;
            if (!Meets(block, kUpperBlocks)) continue;
            if (tile.child == 0)
                Fill(block, kUpperBlocks, tile.value);
            else
                AddUpper(nodes, nodes.ChildOf(tile), block);
        }
    }
    const std::vector<Source>& Sources() const { return sources_; }

  private:
    static constexpr int kUpperBlocks = 512, kLowerBlocks = 16;  ///< along each axis

    void AddUpper(const GridNodes& nodes, const Upper* upper, Int3 origin) {
        for (uint32_t n = 0; n < 1u << 15; ++n) {
            const Int3 block = origin + kLowerBlocks * Int3(n >> 10, n >> 5 & 31, n & 31);
            if (!Meets(block, kLowerBlocks)) continue;
            if (upper->mChildMask.isOn(n))
                AddLower(nodes, nodes.ChildOf<Lower>(upper, n), block);
            else
                Fill(block, kLowerBlocks, upper->mTable[n].value);
        }
    }
    void AddLower(const GridNodes& nodes, const Lower* lower, Int3 origin) {
        for (uint32_t n = 0; n < 1u << 12; ++n) {
            const Int3 block = origin + Int3(n >> 8, n >> 4 & 15, n & 15);
            if (!Meets(block, 1)) continue;
            if (!lower->mChildMask.isOn(n)) {
                Fill(block, 1, lower->mTable[n].value);
                continue;
            }
            Leaf* leaf = nodes.ChildOf<Leaf>(lower, n);
            for (float& value : leaf->mValues) value = Checked(value);
            At(block - first_) = {leaf->mValues, 0};
        }
    }
    bool Meets(Int3 block, int count) const {
        for (int axis = 0; axis < 3; ++axis)
            if (block[axis] + count <= first_[axis] || block[axis] >= first_[axis] + size_[axis])
                return false;
        return true;
    }
    void Fill(Int3 block, int count, float value) {
        const Int3 low = glm::max(block - first_, Int3(0)),
                   high = glm::min(block - first_ + Int3(count), size_);
        const float checked = Checked(value);
        for (int x = low.x; x < high.x; ++x)
            for (int y = low.y; y < high.y; ++y)
                for (int z = low.z; z < high.z; ++z) At({x, y, z}) = {nullptr, checked};
    }
    Source& At(Int3 b) {
        return sources_[(size_t(b.x) * size_t(size_.y) + size_t(b.y)) * size_t(size_.z) + size_t(b.z)];
    }
    float Checked(float value) const {
        if (!std::isfinite(value)) FailDamaged("it has values that are not finite numbers");
        return clampNegative_ ? std::max(0.f, value) : value;
    }

    Int3 first_, size_;
    bool clampNegative_;
    std::vector<Source> sources_;
};

Transform MediumFromIndex(const nanovdb::Map& map) {
    glm::mat4 m(1.f);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) m[column][row] = float(map.mMatD[3 * row + column]);
        m[3][row] = float(map.mVecD[row]);
    }
    const Transform transform(m);
    if (transform.IsSingular()) FailDamaged("its transform cannot be inverted");
    return transform;
}

NanoVdbGrid Convert(GridBytes bytes, bool isOwnVersion, bool clampNegative) {
    const GridNodes nodes(&bytes);
    if (isOwnVersion) nodes.CheckSums();
    const Transform mediumFromIndex = MediumFromIndex(nodes.Grid().mMap);
    const Root& root = nodes.GetRoot();
    Int3 low(0), high(-1);  // an empty grid
    if (root.mTableSize > 0) {
        low = Int3(root.mBBox[0][0], root.mBBox[0][1], root.mBBox[0][2]);
        high = Int3(root.mBBox[1][0], root.mBBox[1][1], root.mBBox[1][2]);
        // Beyond, floats do not tell one voxel from the next.
        constexpr int kFarthest = 1 << 23;
        for (int axis = 0; axis < 3; ++axis)
            if (low[axis] < -kFarthest || high[axis] > kFarthest || low[axis] > high[axis])
                FailDamaged(fmt::format("its active voxels from {} to {} are not in order, or beyond {}",
                                        low[axis], high[axis], kFarthest));
    }
    // With the voxel before the first, from which the field rises.
    const Int3 first = (low - Int3(1)) >> 3, count = (glm::max(high, low) >> 3) - first + Int3(1);
    const double numBlocks = double(count.x + 1) * double(count.y + 1) * double(count.z + 1);
    if (numBlocks > double(NanoVdbFile::kMaxBlocks))
        FailDamaged(fmt::format("it spans {} blocks of 8^3 voxels; the limit is {}", numBlocks,
                                NanoVdbFile::kMaxBlocks));
    BlockTable table(first, count + Int3(1), root.mBackground, clampNegative);
    table.Add(nodes);
    const float background = clampNegative ? std::max(0.f, root.mBackground) : root.mBackground;
    return {SparseGrid(first, count, table.Sources(), background), mediumFromIndex,
            Bounds3(Point3(low), Point3(high + Int3(1)))};
}

}  // namespace

NanoVdbFile::NanoVdbFile(const std::string& path, const FileLoc& loc) : path_(path), loc_(loc) {
    file_ = ReadFileBytes(path, loc, {.maxBytes = size_t(16) << 30});
    size_t position = 0;
    do position = ReadSegment(position);
    while (position < file_.size);
}

void NanoVdbFile::Fail(const std::string& problem) const {
    throw SceneError(loc_, fmt::format("{}: {}", path_, problem));
}

/// Reads the list of the grids from `position` on: a header, an entry for each grid, and then the packed
/// grids. Returns where they end.
size_t NanoVdbFile::ReadSegment(size_t position) {
    const auto take = [&](void* to, uint64_t size) {
        if (size > file_.size - position) Fail("the file ends within its list of grids");
        if (to) std::memcpy(to, file_.data.get() + position, size_t(size));
        position += size_t(size);
    };
    uint64_t magic = 0;
    if (file_.size - position >= sizeof magic) std::memcpy(&magic, file_.data.get() + position, sizeof magic);
    if (magic != NANOVDB_MAGIC_NUMBER)
        Fail(position == 0 ? "is not a NanoVDB file"
                           : fmt::format("no grid begins at byte {}, where one should", position));
    nanovdb::io::Header header;
    take(&header, sizeof header);
    if (header.version.getMajor() != NANOVDB_MAJOR_VERSION_NUMBER)
        Fail(fmt::format("is of version {} of NanoVDB; {} is expected", header.version.getMajor(),
                         NANOVDB_MAJOR_VERSION_NUMBER));
    if (header.codec >= nanovdb::io::Codec::END)
        Fail(fmt::format("is packed in an unknown way ({})", uint16_t(header.codec)));
    if (header.gridCount == 0) Fail("has no grids");
    std::vector<uint64_t> numPacked;
    for (int i = 0; i < header.gridCount; ++i) {
        nanovdb::io::MetaData meta;
        take(&meta, sizeof meta);
        Entry entry;
        const size_t nameAt = position;
        take(nullptr, meta.nameSize);
        entry.name.assign(file_.data.get() + nameAt, meta.nameSize);
        entry.name.resize(std::strlen(entry.name.c_str()));
        entry.version = header.version.id();
        entry.codec = uint16_t(header.codec);
        entry.size = meta.gridSize;
        numPacked.push_back(meta.fileSize);
        entries_.push_back(std::move(entry));
    }
    for (size_t i = 0; i < numPacked.size(); ++i) {
        Entry& entry = entries_[entries_.size() - numPacked.size() + i];
        if (numPacked[i] > file_.size - position)
            Fail(fmt::format("the file ends within the grid \"{}\"", Excerpt(entry.name)));
        entry.packed = file_.View().substr(position, size_t(numPacked[i]));
        position += size_t(numPacked[i]);
    }
    return position;
}

std::vector<std::string> NanoVdbFile::Names() const {
    std::vector<std::string> names;
    for (const Entry& entry : entries_) names.push_back(entry.name);
    return names;
}

NanoVdbGrid NanoVdbFile::Read(const std::string& name, bool clampNegative) const {
    const auto entry =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.name == name; });
    if (entry == entries_.end()) {
        std::string list;
        for (const Entry& e : entries_)
            list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", Excerpt(e.name));
        Fail(fmt::format("has no grid \"{}\"; it has {}", Excerpt(name), list));
    }
    try {
        return Convert(Unpack(entry->packed, entry->size, nanovdb::io::Codec(entry->codec)),
                       entry->version == nanovdb::Version().id(), clampNegative);
    } catch (const Damage& damage) {
        Fail(fmt::format("the grid \"{}\" cannot be used: {}", Excerpt(name), damage.problem));
    } catch (const std::bad_alloc&) {
        Fail(fmt::format("no memory for the grid \"{}\"", Excerpt(name)));
    }
}

}  // namespace lacquer
