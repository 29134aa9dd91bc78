// Knows OpenImageIO's cache of tiles.
#include "pbrt/image/tile_cache.h"

#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>

#include <OpenImageIO/imagecache.h>
#include <fmt/format.h>

namespace lacquer {

namespace {

/// The tiles that one thread has looked up last: most look-ups find theirs here, without asking the library.
struct ThreadTiles {
    struct Slot {
        uint64_t key = 0;  // 0: empty
        OIIO::ImageCache::Tile* tile = nullptr;
        const uint8_t* texels = nullptr;
    };
    static constexpr size_t kSlots = 64;

    explicit ThreadTiles(OIIO::ImageCache* c) : cache(c), thread(c->create_thread_info()) {}
    ThreadTiles(const ThreadTiles&) = delete;
    ThreadTiles& operator=(const ThreadTiles&) = delete;
    ~ThreadTiles() {
        for (const Slot& slot : slots)
            if (slot.tile) cache->release_tile(slot.tile);
        cache->destroy_thread_info(thread);
    }

    OIIO::ImageCache* cache;
    OIIO::ImageCache::Perthread* thread;
    std::array<Slot, kSlots> slots;
    /// Stands for a tile that cannot be read.
    std::vector<uint8_t> zeros;
};

std::atomic<uint64_t> numCaches{0};

}  // namespace

struct TileCache::Parts {
    OIIO::ImageCache* library = OIIO::ImageCache::create(false);
    const uint64_t id = ++numCaches;  // never that of another cache, unlike an address
    std::atomic<uint64_t> numFiles{0};
    std::atomic<bool> hasFailed{false};
    mutable std::mutex mutex;
    std::string failure;
    std::map<std::thread::id, std::unique_ptr<ThreadTiles>> threads;

    ~Parts() {
        threads.clear();
        OIIO::ImageCache::destroy(library);
    }

    ThreadTiles& OfThisThread() {
        thread_local uint64_t owner = 0;
        thread_local ThreadTiles* tiles = nullptr;
        if (owner != id) {
            const std::lock_guard lock(mutex);
            std::unique_ptr<ThreadTiles>& mine = threads[std::this_thread::get_id()];
            if (!mine) mine = std::make_unique<ThreadTiles>(library);
            tiles = mine.get();
            owner = id;
        }
        return *tiles;
    }

    void Fail(const std::string& path) {
        const std::lock_guard lock(mutex);
        std::string problem = library->geterror();
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
    OIIO::ImageCache::ImageHandle* handle = nullptr;
    OIIO::TypeDesc type;
    uint64_t number = 0;  // above zero, different for each file of a cache
};

TileCache::TileCache() : parts_(std::make_unique<Parts>()) {
    OIIO::ImageCache* cache = parts_->library;
    cache->attribute("unassociatedalpha", 1);
    cache->attribute("forcefloat", 0);
    cache->attribute("max_open_files", 400);
    cache->attribute("max_errors_per_file", 1);
}
TileCache::~TileCache() = default;

void TileCache::SetLimit(size_t bytes) {
    parts_->library->attribute("max_memory_MB", float(double(bytes) / (1 << 20)));
}

std::string TileCache::Failure() const {
    const std::lock_guard lock(parts_->mutex);
    return parts_->failure;
}

bool TileCache::HasFailed() const { return parts_->hasFailed.load(std::memory_order_relaxed); }

std::unique_ptr<TiledImage> TileCache::Open(const std::string& path, const std::string& description) {
    std::error_code error;
    const uint64_t bytes = std::filesystem::file_size(path, error);
    if (error) return nullptr;
    OIIO::ImageCache* cache = parts_->library;
    OIIO::ImageCache::Perthread* const thread = parts_->OfThisThread().thread;
    const OIIO::ustring name(path);
    // What this process has seen under that name before may be another file.
    cache->invalidate(name, true);
    OIIO::ImageCache::ImageHandle* const handle = cache->get_image_handle(name, thread);
    OIIO::ImageSpec spec;
    if (!handle || !cache->get_imagespec(handle, thread, spec)) {
        cache->geterror();
        return nullptr;
    }
    TexelFormat format;
    format.numChannels = spec.nchannels;
    format.format = spec.format == OIIO::TypeUInt8  ? PixelFormat::Byte
                    : spec.format == OIIO::TypeHalf ? PixelFormat::Half
                                                    : PixelFormat::Float;
    TiledLayout layout({spec.width, spec.height}, format, description);
    int numLevels = 0;
    cache->get_image_info(handle, thread, 0, 0, OIIO::ustring("miplevels"), OIIO::TypeInt, &numLevels);
    const bool isOurs = spec.get_string_attribute("ImageDescription") == description &&
                        spec.tile_width == kTileSize && spec.tile_height == kTileSize &&
                        layout.Resolution(0) == Int2(spec.width, spec.height) &&
                        numLevels == layout.NumLevels() && bytes == layout.FileBytes();
    if (!isOurs) return nullptr;
    auto file = std::make_unique<TiledImage::File>();
    file->path = path;
    file->handle = handle;
    file->type = spec.format;
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
    OIIO::ImageCache* library = cache_.parts_->library;
    if (slot.tile) library->release_tile(slot.tile);
    slot = {};
    // What another cache at the same address left behind: the library keeps messages by thread and address.
    if (library->has_error()) library->geterror();
    OIIO::ImageCache::Tile* const tile =
        library->get_tile(file_->handle, mine.thread, 0, level, int(x) * kTileSize, int(y) * kTileSize, 0);
    OIIO::TypeDesc type;
    const void* const texels = tile ? library->tile_pixels(tile, type) : nullptr;
    // The library keeps tiles that it could not read, with anything inside.
    if (texels && type == file_->type && !library->has_error() && !cache_.HasFailed()) {
        slot = {key, tile, static_cast<const uint8_t*>(texels)};
        return slot.texels + inTile;
    }
    if (tile) library->release_tile(tile);
    cache_.parts_->Fail(file_->path);
    mine.zeros.resize(layout_.Format().TexelBytes());
    return mine.zeros.data();
}

}  // namespace lacquer
