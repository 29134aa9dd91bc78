// Tiles of pyramids on disk, as many in memory as a limit allows; through OpenImageIO.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pbrt/image/tiled_file.h"

namespace lacquer {

class TiledImage;

/// Reads tiles when they are looked up, and forgets those that nobody looked up for longest. Thread-safe.
class TileCache {
  public:
    TileCache();
    ~TileCache();
    TileCache(const TileCache&) = delete;
    TileCache& operator=(const TileCache&) = delete;

    /// Bytes of tiles to keep; each thread holds some sixty more that it looked up last.
    void SetLimit(size_t bytes);
    /// The pyramid in a file that WriteTiledFile made, of this layout and with this description. Null for any
    /// other file, a damaged one, or none.
    std::unique_ptr<TiledImage> Open(const std::string& path, const std::string& description);
    /// What went wrong in a look-up, "path: problem", empty if nothing did. Look-ups have no way to tell:
    /// they may be within a library that traces rays.
    std::string Failure() const;
    /// True if Failure says something. Cheap.
    bool HasFailed() const;

  private:
    friend class TiledImage;
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// One pyramid on disk. Must not outlive its cache.
class TiledImage {
  public:
    ~TiledImage();
    const TiledLayout& Layout() const { return layout_; }
    /// The stored form of one texel inside a level; good until the calling thread's next look-up. Zeros after
    /// a failure.
    const uint8_t* Texel(int level, Int2 p) const;

  private:
    friend class TileCache;
    struct File;
    TiledImage(TileCache& cache, TiledLayout layout, std::unique_ptr<File> file);
    TileCache& cache_;
    TiledLayout layout_;
    std::unique_ptr<File> file_;
};

}  // namespace lacquer
