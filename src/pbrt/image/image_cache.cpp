#include "pbrt/image/image_cache.h"

#include "pbrt/image/mipmap.h"
#include "pbrt/image/texture_files.h"

namespace lacquer {

namespace {

/// The value of `key`, made by `make` if it is not there; one lock for each entry, so that files load in
/// parallel.
template <class Entries, class Key, class Make>
auto FindOrMake(std::mutex& mutex, Entries& entries, const Key& key, const Make& make) {
    typename Entries::mapped_type entry;
    {
        const std::lock_guard lock(mutex);
        auto& slot = entries[key];
        if (!slot) slot = std::make_shared<typename Entries::mapped_type::element_type>();
        entry = slot;
    }
    const std::lock_guard lock(entry->mutex);
    if (!entry->value) entry->value = make();
    return entry->value;
}

}  // namespace

ImageCache::ImageCache(const TextureMemory& memory, Observer* observer)
    : files_(std::make_unique<TextureFiles>(memory, observer)) {}
ImageCache::~ImageCache() = default;

std::shared_ptr<const Image> ImageCache::Get(const std::string& path, ColorEncoding encoding,
                                             const FileLoc& loc) {
    return FindOrMake(mutex_, images_, std::pair(path, encoding),
                      [&] { return std::make_shared<const Image>(ReadImage(path, encoding, loc)); });
}

std::shared_ptr<const MipMap> ImageCache::GetMipMap(const std::string& path, ColorEncoding encoding,
                                                    WrapMode wrap, const FileLoc& loc) {
    return FindOrMake(mutex_, mipMaps_, std::tuple(path, encoding, wrap), [&] {
        return std::make_shared<const MipMap>(files_->Load(path, encoding, wrap, loc));
    });
}

bool ImageCache::HasFailed() const { return files_->Tiles().HasFailed(); }

void ImageCache::CheckTiles() const { files_->CheckTiles(); }

}  // namespace lacquer
