// Image pyramids with the look-ups of image textures.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pbrt/image/half.h"
#include "pbrt/image/image.h"

namespace lacquer {

enum class TextureFilter { Point, Bilinear, Trilinear, EWA };

/// Where and how widely a texture is looked up, in units of the image; (0,0) is its top left corner.
struct TextureFootprint {
    Point2 st{0};
    Vec2 dstdx{0}, dstdy{0};  ///< change of st from one pixel to its neighbours
};

/// Levels from the full image, resampled to powers of two, down to one texel; each texel of a level is the
/// mean of 2x2 texels below. Kept in the precision of the image's file (bytes stay bytes). Immutable;
/// look-ups are O(1), EWA O(anisotropy^2), without allocation, finite for any footprint.
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

    int NumLevels() const { return int(levels_.size()); }
    int NumChannels() const { return numChannels_; }
    Int2 Resolution(int level) const { return levels_[size_t(level)].resolution; }
    /// Bytes of all texels.
    size_t Bytes() const;
    /// Colour space of the image.
    const lacquer::ColorSpace& ColorSpace() const { return *colorSpace_; }
    /// One value, brought in by the wrap mode.
    float Texel(int level, Int2 p, int channel) const;

    /// One number of the filtered image. Of several channels, point and EWA filters and the coarsest level
    /// take R; the others the mean of R, G, B, or A where the image has it (all as pbrt does).
    float FilterFloat(const TextureFootprint& footprint, TextureFilter filter, float maxAnisotropy) const;
    /// The filtered colour; a single channel stands for all three.
    RGB FilterRGB(const TextureFootprint& footprint, TextureFilter filter, float maxAnisotropy) const;

  private:
    struct Level {
        Int2 resolution{0};
        std::vector<uint8_t> bytes;  // exactly one of the three is in use
        std::vector<uint16_t> halves;
        std::vector<float> floats;
    };

    MipMap() = default;
    void AllocateLevel(Level* level, Int2 resolution) const;
    void Store(Level* level, size_t index, float value) const;
    float Fetch(const Level& level, size_t index) const {
        switch (format_) {
            case PixelFormat::Byte:
                return byteTable_[level.bytes[index]];
            case PixelFormat::Half:
                return HalfToFloat(level.halves[index]);
            case PixelFormat::Float:
                break;
        }
        return level.floats[index];
    }
    std::vector<float> StoreBaseLevel(const Image& image, const std::vector<int>& channels, Int2 resolution);
    void AddCoarserLevels(std::vector<float> finer);

    template <class T>
    T TexelAs(int level, Int2 p) const;
    template <class T>
    T BilinearAs(int level, Point2 st) const;
    template <class T>
    T EwaLevel(int level, Point2 st, Vec2 dst0, Vec2 dst1) const;
    template <class T>
    T Ewa(Point2 st, Vec2 dst0, Vec2 dst1, float maxAnisotropy) const;
    template <class T>
    T Filter(const TextureFootprint& f, TextureFilter filter, float maxAnisotropy) const;

    WrapMode wrap_ = WrapMode::Repeat;
    PixelFormat format_ = PixelFormat::Float;
    ColorEncoding encoding_;
    int numChannels_ = 0;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
    std::array<float, 256> byteTable_{};
    std::vector<Level> levels_;
};

}  // namespace lacquer
