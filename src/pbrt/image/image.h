// Images in memory, and on disk through OpenImageIO.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "pbrt/core/color_space.h"
#include "pbrt/core/error.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// How the numbers of an 8- or 16-bit file become linear values.
struct ColorEncoding {
    enum class Kind { Linear, SRGB, Gamma };
    Kind kind = Kind::Linear;
    float gamma = 1;

    /// value in [0,1] as stored to linear
    float ToLinear(float value) const;
    /// linear to the value as stored; input clamped to [0,1]
    float FromLinear(float value) const;
    /// ToLinear(i / 255) for every byte i.
    std::array<float, 256> ByteTable() const;
    /// "sRGB", "linear" or "gamma x" with x in [0.01, 100]; empty optional if it is none of them.
    static std::optional<ColorEncoding> Parse(const std::string& text);
    auto operator<=>(const ColorEncoding&) const = default;  // NOLINT(modernize-use-nullptr): its own zero
};

/// The precision of an image's file; what is derived from the image is kept in the same one.
enum class PixelFormat { Byte, Half, Float };

/// What happens outside of [0,1]^2.
enum class WrapMode { Repeat, Clamp, Black, OctahedralSphere };
/// "repeat", "clamp", "black" or "octahedralsphere".
std::optional<WrapMode> ParseWrapMode(const std::string& text);

/// Value of one metadata entry of a written image. Matrices act on column vectors, as everywhere here; files
/// that keep the row-vector convention (OpenEXR) get them transposed.
using MetadataValue = std::variant<int, float, std::string, std::vector<float>, glm::mat4>;
using Metadata = std::map<std::string, MetadataValue>;

/// Floats, `channels` for each pixel, rows from the top. Linear values.
class Image {
  public:
    Image() = default;
    Image(Int2 resolution, std::vector<std::string> channels);

    Int2 Resolution() const { return resolution_; }
    int NumChannels() const { return int(channels_.size()); }
    const std::vector<std::string>& Channels() const { return channels_; }
    /// Index of a channel by its name, -1 if there is none.
    int FindChannel(const std::string& name) const;
    /// True if channels R, G and B are there, at indices 0, 1, 2 (reading puts them there).
    bool HasRGB() const;
    float Get(Int2 p, int c) const { return pixels_[Index(p, c)]; }
    void Set(Int2 p, int c, float v) { pixels_[Index(p, c)] = v; }
    /// The same for points outside, brought in by `wrap`; 0 for Black.
    float GetWrapped(Int2 p, int c, WrapMode wrap) const;
    /// Bilinear look-up at st in [0,1]^2 (0,0 is the top left corner of the image). 0 if st is not finite.
    float Bilinear(Point2 st, int c, WrapMode wrap) const;
    /// True if some value is NaN or infinite.
    bool HasNonFinite() const;
    std::vector<float>& Pixels() { return pixels_; }
    const std::vector<float>& Pixels() const { return pixels_; }

    /// Colour space of RGB values: of the file's chromaticities where it has them, else sRGB.
    const lacquer::ColorSpace* ColorSpace() const { return colorSpace_; }
    /// That of RGB values, sRGB where nothing is set.
    const lacquer::ColorSpace& ColorSpaceOrSRGB() const {
        return colorSpace_ ? *colorSpace_ : lacquer::ColorSpace::SRGB();
    }
    void SetColorSpace(const lacquer::ColorSpace* space) { colorSpace_ = space; }

    /// This image with more channels behind its own: 0 everywhere.
    Image WithRoomFor(const std::vector<std::string>& channels) const;
    /// This image with one channel more behind the others. @param values  one for each pixel, rows from the
    /// top
    Image WithChannel(const std::string& name, const std::vector<float>& values) const;

    /// Position and full frame of a crop, for files that can say it. Empty and zero mean the image as a
    /// whole.
    Bounds2i dataWindow;
    Int2 fullResolution{0};
    /// The same with what empty and zero stand for: where the pixels lie in the full frame, and its size.
    Bounds2i Window() const { return dataWindow.IsEmpty() ? Bounds2i{{0, 0}, resolution_} : dataWindow; }
    Int2 FrameResolution() const {
        return fullResolution.x > 0 && fullResolution.y > 0 ? fullResolution : resolution_;
    }
    /// Some channels, by index, of a rectangle inside the image, counted in its own pixels. All else stays,
    /// also their place in the full frame.
    Image Part(const Bounds2i& pixels, const std::vector<int>& channels) const;
    /// Those channels of the whole whose names are kept, likewise.
    Image OnlyChannels(const std::function<bool(const std::string&)>& isKept) const;
    /// @param names  as many as there are channels
    void RenameChannels(std::vector<std::string> names);
    Metadata metadata;
    /// Channels that files hold as 32-bit floats even where 16 bits are asked for: ids, counts, positions.
    std::set<std::string> floatChannels;
    /// How the file held the values: set by ReadImage, used to store derived images as compactly.
    PixelFormat format = PixelFormat::Float;
    ColorEncoding encoding;

  private:
    size_t Index(Int2 p, int c) const {
        return (size_t(p.y) * size_t(resolution_.x) + size_t(p.x)) * channels_.size() + size_t(c);
    }
    Int2 resolution_{0};
    std::vector<std::string> channels_;
    std::vector<float> pixels_;
    const lacquer::ColorSpace* colorSpace_ = nullptr;
};

/// Brings `p` into the image; false where the value is black.
bool WrapPixel(Int2* p, Int2 resolution, WrapMode wrap);
/// Brings a finite st near the unit square (by whole periods, or to within one unit of it) where that changes
/// no look-up, so that it can be scaled to pixels and rounded to int.
inline Point2 WrapCoordinates(Point2 st, WrapMode wrap) {
    if (st.x >= -1 && st.y >= -1 && st.x <= 2 && st.y <= 2) return st;
    if (wrap == WrapMode::Repeat) return {st.x - std::floor(st.x), st.y - std::floor(st.y)};
    return glm::clamp(st, Point2(-1), Point2(2));
}

/// Limits of ReadImage: pixels a side, channels, and bytes of the pixels as floats.
inline constexpr int kMaxImageSide = 1 << 16;
inline constexpr int kMaxImageChannels = 1024;
inline constexpr size_t kMaxImageBytes = size_t(1) << 30;

/// Reads an image file into floats. The content tells the format (PNG, EXR, JPEG, GIF, BMP, HDR, PFM, PPM,
/// TIFF, WebP), the extension only that of TGA. 8- and 16-bit PNG values pass through `encoding`; other 8-bit
/// formats always are sRGB, everything else linear. Channels come as Y or R,G,B or R,G,B,A (alpha only of
/// RGBA PNGs, decoded with the same curve as colour), or as named in EXR and TIFF files. Alpha is not
/// multiplied into colours. The first image of a file that holds several. Errors: FileError at `loc` if it
/// cannot be opened; SceneError at `loc` for a file that is damaged, truncated, of an unknown kind, or beyond
/// the limits above.
Image ReadImage(const std::string& path, ColorEncoding encoding, const FileLoc& loc);

/// Writes under a temporary name in the same folder, then renames: a failure leaves what was there. The
/// extension chooses the format. 8-bit formats get sRGB values (RGB converted from the image's colour space)
/// with dither of less than half a step, clamped to [0,1]; `half` asks for 16-bit floats where the format has
/// them. Formats that hold colours only get the first three channels. EXR files carry data and display
/// window, the metadata, and the chromaticities of the colour space. Errors: FileError for an unknown
/// extension, a missing folder, a full disk.
void WriteImage(const Image& image, const std::string& path, bool half = false);
/// The image in another size, each pixel a mean of those under it with the weights of a Blackman-Harris
/// window, which are positive: fireflies spread, but leave no dark rings. Data window and full frame are
/// scaled along; all else stays. NaN and infinity spread to the pixels near them. Errors:
/// std::invalid_argument for a size without pixels or beyond the limits of ReadImage.
Image Resize(const Image& image, Int2 resolution);
/// The extension of a file name without its dot, in lower case: it tells formats apart.
std::string ExtensionOf(const std::string& path);
/// True if there is a writer for the extension of `path`.
bool CanWriteImage(const std::string& path);
/// Extensions with a writer, for messages, in alphabetical order.
std::vector<std::string> WritableExtensions();

}  // namespace lacquer
