#include "pbrt/image/tile_cache.h"

#include <array>
#include <atomic>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pbrt/image/image_library.h"

namespace lacquer {

namespace {

/// The tiles that one thread has looked up last: most look-ups find theirs here, without asking the library.
struct ThreadTiles {
    struct Slot {
        uint64_t key = 0;  // 0: empty
        TileStore::Tile* tile = nullptr;
        const uint8_t* texels = nullptr;
    };
    static constexpr size_t kSlots = 64;

    explicit ThreadTiles(TileStore* s) : store(s), thread(s->BeginThread()) {}
    ThreadTiles(const ThreadTiles&) = delete;
    ThreadTiles& operator=(const ThreadTiles&) = delete;
    ~ThreadTiles() {
        for (const Slot& slot : slots)
            if (slot.tile) store->Release(slot.tile);
        store->EndThread(thread);
    }

    TileStore* store;
    TileStore::Thread* thread;
    std::array<Slot, kSlots> slots;
    /// Stands for a tile that cannot be read.
    std::vector<uint8_t> zeros;
};

std::atomic<uint64_t> numCaches{0};

}  // namespace

struct TileCache::Parts {
    const uint64_t id = ++numCaches;  // never that of another cache, unlike an address
    std::atomic<uint64_t> numFiles{0};
    std::atomic<bool> hasFailed{false};
    mutable std::mutex mutex;
    std::string failure;
    std::optional<size_t> limit;
    /// Made by the first file that is opened; constant then.
    std::unique_ptr<TileStore> store;
    std::map<std::thread::id, std::unique_ptr<ThreadTiles>> threads;

    void SetLimit(size_t bytes) {
        const std::lock_guard lock(mutex);
        limit = bytes;
        if (store) store->SetLimit(bytes);
    }

    TileStore& Store() {
        const std::lock_guard lock(mutex);
        if (!store) {
            store = LoadImageLibrary().MakeTileStore();
            if (limit) store->SetLimit(*limit);
        }
        return *store;
    }

    /// Only once there is a store.
    ThreadTiles& OfThisThread() {
        thread_local uint64_t owner = 0;
        thread_local ThreadTiles* tiles = nullptr;
        if (owner != id) {
            const std::lock_guard lock(mutex);
            std::unique_ptr<ThreadTiles>& mine = threads[std::this_thread::get_id()];
            if (!mine) mine = std::make_unique<ThreadTiles>(store.get());
            tiles = mine.get();
            owner = id;
        }
        return *tiles;
    }

    void Fail(const std::string& path) {
        const std::lock_guard lock(mutex);
        std::string problem = store->TakeError();
        if (hasFailed) return;
        std::error_code ignored;
        if (!std::filesystem::exists(path, ignored)) problem = "the file is gone";
        while (!problem.empty() && std::isspace(static_cast<unsigned char>(problem.back())))
            problem.pop_back();
        failure = fmt::format("{}: cannot be read: {}", path, problem.empty() ? "it is damaged" : problem);
        hasFailed = true;
    }
};

struct TiledImage::File {
    std::string path;
    TileStore::File* handle = nullptr;
    ValueType type = ValueType::Other;
    uint64_t number = 0;  // above zero, different for each file of a cache
};

TileCache::TileCache() : parts_(std::make_unique<Parts>()) {}
TileCache::~TileCache() = default;

void TileCache::SetLimit(size_t bytes) { parts_->SetLimit(bytes); }

std::string TileCache::Failure() const {
    const std::lock_guard lock(parts_->mutex);
    return parts_->failure;
}

bool TileCache::HasFailed() const { return parts_->hasFailed.load(std::memory_order_relaxed); }

std::unique_ptr<TiledImage> TileCache::Open(const std::string& path, const std::string& description) {
    std::error_code error;
    const uint64_t bytes = std::filesystem::file_size(path, error);
    if (error || !HasWholeHead(path)) return nullptr;
    TileStore& store = parts_->Store();
    TileStore::Contents contents;
    TileStore::File* const handle = store.Open(path, parts_->OfThisThread().thread, &contents);
    if (!handle) return nullptr;
    TexelFormat format;
    format.numChannels = contents.numChannels;
    format.format = contents.type == ValueType::UInt8  ? PixelFormat::Byte
                    : contents.type == ValueType::Half ? PixelFormat::Half
                                                       : PixelFormat::Float;
    TiledLayout layout(contents.resolution, format, description);
    const bool isOurs = contents.description == description && contents.tile == Int2(kTileSize) &&
                        layout.Resolution(0) == contents.resolution &&
                        contents.numLevels == layout.NumLevels() && bytes == layout.FileBytes();
    if (!isOurs) return nullptr;
    auto file = std::make_unique<TiledImage::File>();
    file->path = path;
    file->handle = handle;
    file->type = contents.type;
    file->number = ++parts_->numFiles;
    return std::unique_ptr<TiledImage>(new TiledImage(*this, std::move(layout), std::move(file)));
}

TiledImage::TiledImage(TileCache& cache, TiledLayout layout, std::unique_ptr<File> file)
    : cache_(cache), layout_(std::move(layout)), file_(std::move(file)) {}
TiledImage::~TiledImage() = default;

const uint8_t* TiledImage::Texel(int level, Int2 p) const {
    ThreadTiles& mine = cache_.parts_->OfThisThread();
    const auto x = unsigned(p.x) / kTileSize, y = unsigned(p.y) / kTileSize;
    const size_t inTile = (size_t(unsigned(p.y) % kTileSize) * kTileSize + unsigned(p.x) % kTileSize) *
                          layout_.Format().TexelBytes();
    // Sides have at most 2^16 texels, so tiles are numbered below 2^10 along each axis, levels below 2^5.
    const uint64_t key = file_->number << 25 | uint64_t(level) << 20 | uint64_t(y) << 10 | x;
    // Neighbouring tiles get different slots.
    const size_t index = (x + 8 * y + 13 * unsigned(level) + 29 * file_->number) % ThreadTiles::kSlots;
    ThreadTiles::Slot& slot = mine.slots[index];
    if (slot.key == key) return slot.texels + inTile;

    // Fetch the tile, which may read it, and keep it from being forgotten.
    TileStore& store = *mine.store;
    if (slot.tile) store.Release(slot.tile);
    slot = {};
    const TileStore::Texels texels =
        store.Get(file_->handle, mine.thread, level, Int2(x, y) * kTileSize, file_->type);
    if (texels.tile && !cache_.HasFailed()) {
        slot = {key, texels.tile, texels.values};
        return slot.texels + inTile;
    }
    if (texels.tile) store.Release(texels.tile);
    cache_.parts_->Fail(file_->path);
    mine.zeros.resize(layout_.Format().TexelBytes());
    return mine.zeros.data();
}

}  // namespace lacquer
