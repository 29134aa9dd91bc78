// Which image textures are in memory and which on disk, and the folder of tiled files.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "pbrt/image/mipmap.h"
#include "pbrt/image/texture_memory.h"
#include "pbrt/image/tile_cache.h"

namespace lacquer {

class Observer;
struct TextureImage;

/// Loads pyramids within a limit of memory. Thread-safe.
class TextureFiles {
  public:
    TextureFiles(const TextureMemory& memory, Observer* observer);
    /// Removes the temporary folder, if there is one.
    ~TextureFiles();
    TextureFiles(const TextureFiles&) = delete;
    TextureFiles& operator=(const TextureFiles&) = delete;

    /// The pyramid of an image: an array where there is room for it, else from a tiled file, which is made
    /// unless there is one of this very image. Errors: as ImageCache::GetMipMap.
    /// @param progress  hears of the rows that are read; may be null
    MipMap Load(const TextureImage& image, const FileLoc& loc, Observer* progress = nullptr);
    /// Takes the memory of a pyramid that Load() has made as free again.
    void Forget(const MipMap& map);
    const TileCache& Tiles() const { return tiles_; }
    /// Errors: FileError if a tile could not be read.
    void CheckTiles() const;

  private:
    /// What a tiled file is made from. Two files of one name are of the same image if the descriptions agree.
    struct Origin {
        const TextureImage& image;
        std::string name, description;
    };
    static std::optional<Origin> OriginOf(const TextureImage& image);
    bool UsesDisk() const { return !memory_.cacheFolder.empty() || !memory_.temporaryFolder.empty(); }
    /// True if a pyramid of so many bytes may be an array; then they are counted.
    bool Reserve(size_t bytes);
    /// Returns what was counted too much.
    void Release(size_t bytes);
    const std::string& Folder();
    void MakeTemporaryFolder();
    std::unique_ptr<TiledImage> Find(const Origin& origin);
    std::unique_ptr<TiledImage> Convert(const Origin& origin, int rows, const FileLoc& loc,
                                        Observer* observer);

    TextureMemory memory_;
    Observer* observer_;
    TileCache tiles_;
    std::mutex mutex_;     // of all below
    size_t resident_ = 0;  // bytes of arrays
    std::string folder_;   // of tiled files, once there is one
    bool isTemporary_ = false;
};

}  // namespace lacquer
