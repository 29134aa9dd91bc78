// What Lacquer asks of OpenImageIO, in types of its own. OpenImageIO brings hundreds of libraries, and
// starting them takes longer than many a command; so whatever knows it is a module (folder openimageio),
// loaded when the first image file needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pbrt/core/vec.h"
#include "pbrt/image/image.h"

namespace lacquer {

/// Type of the values of a file, or of an array.
enum class ValueType { UInt8, UInt16, Half, Float, Other };

/// What a file has beside the pixels.
struct ImageContents {
    Int2 resolution{0};
    int depth = 1;
    bool isDeep = false;
    Int2 origin{0};                         ///< of the pixels in the full frame
    Int2 fullOrigin{0}, fullResolution{0};  ///< of the frame
    int tileRows = 0;                       ///< 0 if the file has rows rather than tiles
    std::vector<std::string> channels;
    ValueType type = ValueType::Float;    ///< of all channels, or the widest of them
    std::vector<ValueType> channelTypes;  ///< empty if all have the same
    std::vector<std::pair<std::string, MetadataValue>> attributes;
};

/// The first image of an open file. Errors of all functions: std::exception with what is wrong with the file.
class ImageReader {
  public:
    ImageReader() = default;
    ImageReader(const ImageReader&) = delete;
    ImageReader& operator=(const ImageReader&) = delete;
    virtual ~ImageReader() = default;
    virtual const ImageContents& Contents() const = 0;
    /// All pixels, with all channels, converted to `type`.
    virtual void Read(ValueType type, void* values) = 0;
    /// Rows [begin, end) from the top, the same way.
    virtual void ReadRows(int begin, int end, ValueType type, void* values) = 0;
};

/// Tiles of files, as many in memory as a limit allows. Thread-safe; a thread's messages are its own.
class TileStore {
  public:
    // Handles of the library.
    struct File;
    struct Thread;
    struct Tile;
    struct Contents {
        Int2 resolution{0}, tile{0};
        int numChannels = 0, numLevels = 0;
        ValueType type = ValueType::Other;
        std::string description;
    };
    /// Good until the tile is released. Null if it cannot be read.
    struct Texels {
        Tile* tile = nullptr;
        const uint8_t* values = nullptr;
    };

    TileStore() = default;
    TileStore(const TileStore&) = delete;
    TileStore& operator=(const TileStore&) = delete;
    /// No thread may be left.
    virtual ~TileStore() = default;
    virtual void SetLimit(size_t bytes) = 0;
    virtual Thread* BeginThread() = 0;
    virtual void EndThread(Thread* thread) = 0;
    /// Null if it is no image. What was known of a file of this name is forgotten.
    virtual File* Open(const std::string& path, Thread* thread, Contents* contents) = 0;
    /// @param corner  of the tile, in texels
    /// @param type  of the file's values
    virtual Texels Get(File* file, Thread* thread, int level, Int2 corner, ValueType type) = 0;
    virtual void Release(Tile* tile) = 0;
    /// What went wrong last in this thread, and forgets it.
    virtual std::string TakeError() = 0;
};

/// Thread-safe. Errors: std::exception with what the library says.
class ImageLibrary {
  public:
    /// Changes with every change of this file: a program takes no module of another version.
    static constexpr int kVersion = 1;

    ImageLibrary() = default;
    ImageLibrary(const ImageLibrary&) = delete;
    ImageLibrary& operator=(const ImageLibrary&) = delete;
    virtual ~ImageLibrary() = default;

    /// Opens a file of a format, by the library's name of it. Null if there is no reader.
    virtual std::unique_ptr<ImageReader> Open(const std::string& format, const std::string& path) const = 0;

    /// Whether there is a writer of a format, by the library's name of it.
    virtual bool Writes(const std::string& format) const = 0;
    struct WriterLimits {
        bool holdsAnyChannels = false, holdsAlpha = false;
    };
    virtual WriterLimits LimitsOf(const std::string& extension) const = 0;
    /// The bytes of a file.
    /// @param values  bytes if the type of the contents is UInt8, else floats
    /// @param path  the file's name-to-be
    virtual std::vector<unsigned char> Encode(const ImageContents& contents, const void* values,
                                              const std::string& extension,
                                              const std::string& path) const = 0;

    /// An image in another resolution, by one of the library's filters.
    template <class Float>
    struct Pixels {
        Int2 resolution{0};
        Float* values = nullptr;
    };
    virtual void Resize(const Pixels<const float>& from, const Pixels<float>& to, int channels,
                        const std::string& filter) const = 0;

    virtual std::unique_ptr<TileStore> MakeTileStore() const = 0;
};

/// The library, loaded by the first call. Thread-safe. Errors: FileError if it cannot be loaded; the next
/// call tries again.
const ImageLibrary& LoadImageLibrary();

/// A message of the library on one line, without trailing blanks.
std::string OneLine(const std::string& message);

}  // namespace lacquer

/// What the module exports: the library, null for another version than its own.
extern "C" [[gnu::visibility("default")]] const lacquer::ImageLibrary* LacquerOpenImageIO(int version);
