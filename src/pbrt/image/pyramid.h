// From the rows of an image to the levels of its pyramid, one row after the other: the whole image need not
// be in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer {

/// How the texels of a pyramid are stored: as in the image's file, so that bytes stay bytes.
struct TexelFormat {
    PixelFormat format = PixelFormat::Float;
    ColorEncoding encoding;  ///< of bytes
    int numChannels = 1;

    /// Bytes of one value, and of a texel.
    size_t ValueBytes() const {
        return format == PixelFormat::Byte ? 1 : format == PixelFormat::Half ? 2 : 4;
    }
    size_t TexelBytes() const { return ValueBytes() * size_t(numChannels); }
};

/// The image of a pyramid: used channels only, linear finite values.
class PyramidSource {
  public:
    /// Values at most this many pixels from an edge can be asked for in any order.
    static constexpr int kEdge = 2;

    virtual ~PyramidSource() = default;
    virtual Int2 Resolution() const = 0;
    virtual int NumChannels() const = 0;
    /// Row y from the top, its values pixel by pixel, good until the next call. Each row is asked for once,
    /// in ascending order. Errors: those of the file behind it.
    virtual const float* Row(int y) = 0;
    virtual float EdgeValue(Int2 p, int channel) const = 0;
    /// The smallest value of all.
    virtual float Lowest() const = 0;
};

/// Takes the rows of all levels.
class PyramidSink {
  public:
    virtual ~PyramidSink() = default;
    /// Row y of a level, texels one after the other. Rows of one level come in ascending order, those of
    /// different levels in between each other.
    virtual void TakeRow(int level, int y, const uint8_t* texels) = 0;
};

/// Resolutions of the levels: the image enlarged to powers of two, then halved down to one texel.
std::vector<Int2> PyramidLevels(Int2 image);
/// Bytes of all texels.
size_t PyramidBytes(Int2 image, const TexelFormat& format);

/// Makes all levels; each texel of a level is the mean of 2x2 texels below, and rounding to the format does
/// not add up over the levels. Memory: some rows. `wrap` tells what an enlarged image has beyond its edges.
void MakePyramid(PyramidSource& source, const TexelFormat& format, WrapMode wrap, PyramidSink& sink);

}  // namespace lacquer
