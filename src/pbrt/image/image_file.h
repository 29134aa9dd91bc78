// Image files, opened and then read as a whole or row by row.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer {

/// What a file says about its image before the pixels.
struct ImageHeader {
    Int2 resolution{0};
    std::vector<std::string> channels;  ///< as ReadImage gives them
    PixelFormat format = PixelFormat::Float;
    ColorEncoding encoding;  ///< of bytes
    const ColorSpace* colorSpace = nullptr;
};

/// An image file that is open.
class ImageFile {
  public:
    /// Errors: those of ReadImage about the header; the limit of bytes is that of the pixels as the file has
    /// them.
    /// @param wasRead  the very file was read before without errors: its structure is not gone through again
    ImageFile(const std::string& path, ColorEncoding encoding, const FileLoc& loc, bool wasRead = false);
    ~ImageFile();
    ImageFile(const ImageFile&) = delete;
    ImageFile& operator=(const ImageFile&) = delete;

    const ImageHeader& Header() const;
    /// The whole image. Errors: those of ReadImage.
    Image Read();
    /// Goes over the file for damage that ReadRows may take for pixels; Read does so itself. Errors: those of
    /// ReadImage.
    void CheckPixels() const;
    /// How many rows are best read together.
    int RowsAtOnce() const;
    /// Rows [begin, end) from the top, with all channels, linear. Goes forward: `begin` is a multiple of
    /// RowsAtOnce(), and larger from call to call. Errors: those of ReadImage.
    void ReadRows(int begin, int end, float* values);

  private:
    class Reader;
    std::unique_ptr<Reader> reader_;
};

}  // namespace lacquer
