// Image files that scenes name, each read once, and their pyramids.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pbrt/core/kept_files.h"
#include "pbrt/image/image.h"
#include "pbrt/image/texture_memory.h"

namespace lacquer {

class MipMap;
class Observer;
class TextureFiles;

/// An image as a texture reads it.
struct TextureImage {
    std::string path;
    ColorEncoding encoding;
    WrapMode wrap = WrapMode::Repeat;
    auto operator<=>(const TextureImage&) const = default;  // NOLINT(modernize-use-nullptr): its own zero
};

/// Reads each file once for each encoding. Thread-safe; different files are read in parallel.
class ImageCache {
  public:
    /// @param observer  hears of tiled files that are made, and of folders that are of no use; may be null
    explicit ImageCache(const TextureMemory& memory = {}, Observer* observer = nullptr);
    ~ImageCache();
    ImageCache(const ImageCache&) = delete;
    ImageCache& operator=(const ImageCache&) = delete;

    /// Errors: those of ReadImage; a file that failed is tried again at the next call.
    std::shared_ptr<const Image> Get(const std::string& path, ColorEncoding encoding, const FileLoc& loc);
    /// The image's pyramid for textures, in memory or on disk; the image itself is not kept. Must not outlive
    /// the cache if it is on disk. Errors: those of ReadImage and MipMap::Make; FileError if a tiled file
    /// cannot be made.
    std::shared_ptr<const MipMap> GetMipMap(const TextureImage& image, const FileLoc& loc);
    /// Makes the pyramids of many images by all threads, for those who ask for them later. Which of them are
    /// on disk may depend on the threads where not all have room in memory. What fails is left to whoever
    /// asks for it. Memory: for each thread one image as floats, beside the pyramids.
    void ReadAhead(std::vector<TextureImage> images);
    /// True if a tile could not be read: what was looked up since is black. Cheap; for each tile of an image.
    bool HasFailed() const;
    /// Errors: FileError if HasFailed().
    void CheckTiles() const;
    /// As of KeptFiles, for those that several scenes use, one after another.
    void BeginScene();
    void DropUnused();

  private:
    enum class Report { Progress, None };
    std::shared_ptr<const MipMap> GetMipMap(const TextureImage& image, const FileLoc& loc, Report report);

    Observer* observer_;
    KeptFiles<std::pair<std::string, ColorEncoding>, Image> images_;
    std::unique_ptr<TextureFiles> files_;  // before the pyramids, which need it
    KeptFiles<TextureImage, MipMap> mipMaps_;
};

}  // namespace lacquer
