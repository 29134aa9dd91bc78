// OpenImageIO's cache of tiles as a TileStore.
#include "pbrt/image/openimageio/tiles.h"

#include <cstdint>
#include <memory>
#include <string>

#include <OpenImageIO/imagecache.h>

#include "pbrt/image/openimageio/value_type.h"

namespace lacquer::openimageio {

namespace {

using OIIO::ImageCache;

ImageCache::ImageHandle* Unwrap(TileStore::File* file) {
    return reinterpret_cast<ImageCache::ImageHandle*>(file);
}
ImageCache::Perthread* Unwrap(TileStore::Thread* thread) {
    return reinterpret_cast<ImageCache::Perthread*>(thread);
}
ImageCache::Tile* Unwrap(TileStore::Tile* tile) { return reinterpret_cast<ImageCache::Tile*>(tile); }

class Tiles : public TileStore {
  public:
    Tiles() : cache_(ImageCache::create(false)) {
        cache_->attribute("unassociatedalpha", 1);
        cache_->attribute("forcefloat", 0);
        cache_->attribute("max_open_files", 400);
        cache_->attribute("max_errors_per_file", 1);
    }
    ~Tiles() override { ImageCache::destroy(cache_); }

    void SetLimit(size_t bytes) override {
        cache_->attribute("max_memory_MB", float(double(bytes) / (1 << 20)));
    }

    Thread* BeginThread() override { return reinterpret_cast<Thread*>(cache_->create_thread_info()); }
    void EndThread(Thread* thread) override { cache_->destroy_thread_info(Unwrap(thread)); }

    File* Open(const std::string& path, Thread* thread, Contents* contents) override {
        const OIIO::ustring name(path);
        cache_->invalidate(name, true);
        ImageCache::ImageHandle* const handle = cache_->get_image_handle(name, Unwrap(thread));
        OIIO::ImageSpec spec;
        if (!handle || !cache_->get_imagespec(handle, Unwrap(thread), spec)) {
            cache_->geterror();
            return nullptr;
        }
        contents->resolution = {spec.width, spec.height};
        contents->tile = {spec.tile_width, spec.tile_height};
        contents->numChannels = spec.nchannels;
        contents->type = ValueTypeOf(spec.format);
        contents->description = spec.get_string_attribute("ImageDescription");
        cache_->get_image_info(handle, Unwrap(thread), 0, 0, OIIO::ustring("miplevels"), OIIO::TypeInt,
                               &contents->numLevels);
        return reinterpret_cast<File*>(handle);
    }

    Texels Get(File* file, Thread* thread, int level, Int2 corner, ValueType type) override {
        // What another cache at the same address left behind: the library keeps messages by thread and
        // address.
        if (cache_->has_error()) cache_->geterror();
        ImageCache::Tile* const tile =
            cache_->get_tile(Unwrap(file), Unwrap(thread), 0, level, corner.x, corner.y, 0);
        OIIO::TypeDesc found;
        const void* const values = tile ? cache_->tile_pixels(tile, found) : nullptr;
        // The library keeps tiles that it could not read, with anything inside.
        if (values && found == TypeDescOf(type) && !cache_->has_error())
            return {reinterpret_cast<Tile*>(tile), static_cast<const uint8_t*>(values)};
        if (tile) cache_->release_tile(tile);
        return {};
    }

    void Release(Tile* tile) override { cache_->release_tile(Unwrap(tile)); }
    std::string TakeError() override { return cache_->geterror(); }

  private:
    ImageCache* cache_;
};

}  // namespace

std::unique_ptr<TileStore> MakeTiles() { return std::make_unique<Tiles>(); }

}  // namespace lacquer::openimageio
