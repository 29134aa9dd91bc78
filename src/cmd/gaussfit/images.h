// Images for pages that need no other file: colours of values, and PNG as data URIs.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace lacquer::cmd {

/// A small image in colours, row by row from the top.
class ColorImage {
  public:
    ColorImage(int width, int height)
        : width_(width), height_(height), bytes_(size_t(width) * size_t(height) * 3) {}
    int Width() const { return width_; }
    int Height() const { return height_; }
    /// Colours a pixel by a value: 0 and less is the darkest colour, 1 and more the lightest, NaN grey.
    void SetValue(int x, int y, double value);
    /// "data:image/png;base64,...".
    std::string DataUri() const;

  private:
    int width_, height_;
    std::vector<uint8_t> bytes_;
};

/// Red, green and blue (0 to 255) of a value in [0, 1]: dark blue over green to light yellow, ever lighter.
std::array<uint8_t, 3> ColorOf(double value);

}  // namespace lacquer::cmd
