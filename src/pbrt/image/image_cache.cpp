#include "pbrt/image/image_cache.h"

#include "pbrt/image/mipmap.h"
#include "pbrt/image/texture_files.h"

namespace lacquer {

ImageCache::ImageCache(const TextureMemory& memory, Observer* observer)
    : files_(std::make_unique<TextureFiles>(memory, observer)),
      mipMaps_([this](const MipMap& map) { files_->Forget(map); }) {}
ImageCache::~ImageCache() = default;

std::shared_ptr<const Image> ImageCache::Get(const std::string& path, ColorEncoding encoding,
                                             const FileLoc& loc) {
    return images_.Get({path, encoding}, path, [&] { return ReadImage(path, encoding, loc); });
}

std::shared_ptr<const MipMap> ImageCache::GetMipMap(const std::string& path, ColorEncoding encoding,
                                                    WrapMode wrap, const FileLoc& loc) {
    return mipMaps_.Get({path, encoding, wrap}, path,
                        [&] { return files_->Load(path, encoding, wrap, loc); });
}

void ImageCache::BeginScene() {
    images_.BeginScene();
    mipMaps_.BeginScene();
}

void ImageCache::DropUnused() {
    images_.DropUnused();
    mipMaps_.DropUnused();
}

bool ImageCache::HasFailed() const { return files_->Tiles().HasFailed(); }

void ImageCache::CheckTiles() const { files_->CheckTiles(); }

}  // namespace lacquer
