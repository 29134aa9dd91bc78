#include "pbrt/image/image_cache.h"

#include <algorithm>
#include <exception>

#include "pbrt/core/parallel.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/mipmap.h"
#include "pbrt/image/texture_files.h"

namespace lacquer {

ImageCache::ImageCache(const TextureMemory& memory, Observer* observer)
    : observer_(observer),
      files_(std::make_unique<TextureFiles>(memory, observer)),
      mipMaps_([this](const MipMap& map) { files_->Forget(map); }) {}
ImageCache::~ImageCache() = default;

std::shared_ptr<const Image> ImageCache::Get(const std::string& path, ColorEncoding encoding,
                                             const FileLoc& loc) {
    return images_.Get({path, encoding}, path, [&] { return ReadImage(path, encoding, loc); });
}

std::shared_ptr<const MipMap> ImageCache::GetMipMap(const TextureImage& image, const FileLoc& loc,
                                                    Report report) {
    return mipMaps_.Get(image, image.path, [&] {
        return files_->Load(image, loc, report == Report::Progress ? observer_ : nullptr);
    });
}

std::shared_ptr<const MipMap> ImageCache::GetMipMap(const TextureImage& image, const FileLoc& loc) {
    return GetMipMap(image, loc, Report::Progress);
}

void ImageCache::ReadAhead(std::vector<TextureImage> images) {
    std::sort(images.begin(), images.end());
    images.erase(std::unique(images.begin(), images.end()), images.end());
    if (images.size() < 2) return;  // as well read when it is asked for, which tells more of the progress
    if (observer_) observer_->Begin("Reading textures", int64_t(images.size()), "");
    ParallelFor(int64_t(images.size()), [&](int64_t i) {
        try {
            GetMipMap(images[size_t(i)], {}, Report::None);
        } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): told to whoever asks for it
        }
        if (observer_) observer_->Advance(1);
    });
    if (observer_) observer_->End();
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
