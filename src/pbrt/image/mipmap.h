// Image pyramids with the look-ups of image textures.
#pragma once

#include <array>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer {

class TiledImage;

enum class TextureFilter { Point, Bilinear, Trilinear, EWA };

/// Where and how widely a texture is looked up, in units of the image; (0,0) is its top left corner.
struct TextureFootprint {
    Point2 st{0};
    Vec2 dstdx{0}, dstdy{0};  ///< change of st from one pixel to its neighbours
};

/// Levels from the full image, resampled to powers of two, down to one texel; each texel of a level is the
/// mean of 2x2 texels below. Kept in the precision of the image's file (bytes stay bytes), in memory or as a
/// file of tiles: look-ups give the same bits. Immutable; look-ups are O(1), EWA O(anisotropy^2), without
/// allocation (but for tiles read from a file), finite for any footprint.
class MipMap {
  public:
    /// Largest maxAnisotropy: an ellipse at most this many times longer than wide touches some ten thousand
    /// texels at worst; beyond it one look-up could take milliseconds.
    static constexpr float kMaxAnisotropy = 64;

    /// @param image  one channel, or R, G, B with or without A; A is dropped where it is 1 everywhere
    /// @param path, loc  for messages
    /// Errors: SceneError at `loc` for other channels, values that are not finite, and more than
    /// kMaxImageBytes.
    static MipMap Make(const Image& image, WrapMode wrap, const std::string& path, const FileLoc& loc);
    /// A pyramid on disk. @param encoding  of bytes @param space  of the image that it was made from
    static MipMap OnDisk(std::unique_ptr<const TiledImage> tiles, ColorEncoding encoding, WrapMode wrap,
                         const lacquer::ColorSpace& space);
    MipMap(MipMap&&) noexcept;
    MipMap& operator=(MipMap&&) noexcept;
    ~MipMap();

    int NumLevels() const { return int(levels_.size()); }
    int NumChannels() const { return numChannels_; }
    Int2 Resolution(int level) const { return levels_[size_t(level)].resolution; }
    /// Bytes of all texels in memory: none of a pyramid on disk.
    size_t Bytes() const;
    /// Colour space of the image.
    const lacquer::ColorSpace& ColorSpace() const { return *colorSpace_; }
    /// One value, brought in by the wrap mode.
    float Texel(int level, Int2 p, int channel) const;

    /// One number of the filtered image. Of several channels, point and EWA filters and the coarsest level
    /// take R; the others the mean of R, G, B, or A where the image has it (all as pbrt does).
    float FilterFloat(const TextureFootprint& footprint, TextureFilter filter, float maxAnisotropy) const {
        return lookups_.filterFloat(*this, footprint, filter, maxAnisotropy);
    }
    /// The filtered colour; a single channel stands for all three.
    RGB FilterRGB(const TextureFootprint& footprint, TextureFilter filter, float maxAnisotropy) const {
        // A number comes back faster than three.
        if (numChannels_ == 1) return RGB(FilterFloat(footprint, filter, maxAnisotropy));
        return lookups_.filterRGB(*this, footprint, filter, maxAnisotropy);
    }

  private:
    static constexpr std::align_val_t kCacheLine{64};
    struct FreeAligned {
        void operator()(uint8_t* texels) const { ::operator delete[](texels, kCacheLine); }
    };
    struct Level {
        explicit Level(Int2 sides);
        // Of a texel in memory, where square tiles stand row by row, so that texels on one another are close:
        // 8 x 8 texels of a byte are a line of the cache. All sides are powers of two.
        size_t IndexOf(Int2 p) const {
            const size_t x = size_t(p.x), y = size_t(p.y), mask = (size_t(1) << tileBits) - 1;
            return ((y >> tileBits) << (widthBits + tileBits)) + ((y & mask) << tileBits) +
                   ((x >> tileBits) << (2 * tileBits)) + (x & mask);
        }

        Int2 resolution;
        Vec2 size;                // the same
        int widthBits, tileBits;  // logarithms of the width, and of a tile's sides
        size_t bytes = 0;         // 0 on disk
        std::unique_ptr<uint8_t[], FreeAligned> texels;
    };
    class LevelSink;
    template <class Storage>
    friend class TextureLookup;

    MipMap();
    /// The look-ups, as they are compiled for one way of storing texels.
    struct Lookups {
        float (*value)(const MipMap&, int level, Int2 p, int channel);
        float (*filterFloat)(const MipMap&, const TextureFootprint&, TextureFilter, float);
        RGB (*filterRGB)(const MipMap&, const TextureFootprint&, TextureFilter, float);
    };
    template <class Storage>
    static Lookups LookupsOf();
    void ChooseLookups();

    Lookups lookups_{};
    WrapMode wrap_ = WrapMode::Repeat;
    PixelFormat format_ = PixelFormat::Float;
    int numChannels_ = 0;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
    std::array<float, 256> byteTable_{};
    std::vector<Level> levels_;
    std::unique_ptr<const TiledImage> tiles_;
};

}  // namespace lacquer
