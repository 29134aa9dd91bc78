// Pictures in memory, and on disk through OpenImageIO.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
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
    float FromLinear(float value) const;
    /// "sRGB", "linear" or "gamma x"; empty optional if it is none of them.
    static std::optional<ColorEncoding> Parse(const std::string& text);
    auto operator<=>(const ColorEncoding&) const = default;
};

/// What happens outside of [0,1]^2.
enum class WrapMode { Repeat, Clamp, Black, OctahedralSphere };

/// Value of one metadata entry of a written image.
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
    /// True if channels R, G and B are there (indices 0, 1, 2 after reading).
    bool HasRGB() const { return NumChannels() >= 3; }
    float Get(Int2 p, int c) const { return pixels_[Index(p, c)]; }
    void Set(Int2 p, int c, float v) { pixels_[Index(p, c)] = v; }
    /// The same for points outside, brought in by `wrap`; 0 for Black.
    float GetWrapped(Int2 p, int c, WrapMode wrap) const;
    /// Bilinear look-up at st in [0,1]^2 (0,0 is the top left corner of the image).
    float Bilinear(Point2 st, int c, WrapMode wrap) const;
    std::vector<float>& Pixels() { return pixels_; }
    const std::vector<float>& Pixels() const { return pixels_; }

    /// Colour space of RGB values: of the file's chromaticities where it has them, else sRGB.
    const lacquer::ColorSpace* ColorSpace() const { return colorSpace_; }
    void SetColorSpace(const lacquer::ColorSpace* space) { colorSpace_ = space; }

    /// Position and full frame of a crop, for files that can say it.
    Bounds2i dataWindow;
    Int2 fullResolution{0};
    Metadata metadata;

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

/// Reads any format that OpenImageIO knows into floats; 8- and 16-bit values pass through `encoding` (8-bit
/// formats other than PNG always are sRGB). Channels come as Y; Y,A; R,G,B; R,G,B,A or as named in the file.
/// Limits: 2^16 pixels a side, 1 GiB as floats.
/// Errors: FileError if it cannot be opened; SceneError at `loc` for a file that is damaged or too large.
Image ReadImage(const std::string& path, ColorEncoding encoding, const FileLoc& loc);

/// Writes under a temporary name, then renames. The extension chooses the format; 8-bit formats get sRGB values with
/// dither, clamped to [0,1]; `half` asks for 16-bit floats where the format has them.
/// Errors: FileError.
void WriteImage(const Image& image, const std::string& path, bool half = false);
/// True if there is a writer for the extension of `path`.
bool CanWriteImage(const std::string& path);
/// Extensions with a writer, for messages.
std::vector<std::string> WritableExtensions();

/// Reads each file once for each encoding.
class ImageCache {
  public:
    std::shared_ptr<const Image> Get(const std::string& path, ColorEncoding encoding, const FileLoc& loc);

  private:
    std::mutex mutex_;
    std::map<std::pair<std::string, ColorEncoding>, std::shared_ptr<const Image>> images_;
};

}  // namespace lacquer
