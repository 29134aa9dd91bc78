// A drawing surface for plots: shapes and text with smooth edges, and colour scales.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::plot {

/// Letters as strokes (data/font/plain.txt describes the format and the units).
class StrokeFont {
  public:
    struct Glyph {
        float advance = 0;
        std::vector<std::vector<Vec2>> strokes;  ///< polylines, y upward from the baseline
    };
    static constexpr float kCapitalHeight = 7;

    /// Reads a font. Errors: std::logic_error for a line that it does not understand (our own data).
    explicit StrokeFont(std::string_view text);
    /// The font that the program carries.
    static const StrokeFont& Plain();
    /// The glyph of a code point; a box for one that the font lacks.
    const Glyph& Find(char32_t c) const;
    bool Has(char32_t c) const { return glyphs_.contains(c); }

  private:
    std::map<char32_t, Glyph> glyphs_;
    Glyph missing_;
};

/// Code points of a UTF-8 text; U+FFFD for bytes that are none.
std::u32string DecodeUtf8(std::string_view text);

/// A colour given as 0xRRGGBB in sRGB, in linear values.
RGB ColorOf(unsigned hex);

/// A colour for each t in [0,1], equally different for equal steps: made in OKLab [Ottosson 2020], where the
/// lightness is linear in t and chroma is reduced where sRGB ends. Linear sRGB values.
class ColorScale {
  public:
    /// Black over violet, red and orange to a pale yellow; brighter is more.
    static const ColorScale& Sequential();
    /// Blue (0) over a light grey (1/2) to red (1).
    static const ColorScale& Diverging();
    /// NaN is taken as 0.
    RGB At(double t) const;

  private:
    explicit ColorScale(const std::function<Vec3(double)>& oklch);
    std::vector<RGB> colors_;
};
/// OKLab of a linear sRGB colour: lightness in [0,1], a, b.
Vec3 OklabFromLinear(RGB rgb);

enum class Align { Left, Center, Right };

/// Pixels with the origin at the top left; positions and sizes are in pixels and need not be whole.
class Canvas {
  public:
    Canvas(int width, int height, RGB background);
    int Width() const { return image_.Resolution().x; }
    int Height() const { return image_.Resolution().y; }

    /// Lays `color` over a pixel; parts outside of the canvas are left out, here and everywhere.
    void Blend(int x, int y, RGB color, float coverage);
    void FillRectangle(float x, float y, float width, float height, RGB color, float opacity = 1);
    void FillCircle(Vec2 center, float radius, RGB color, float opacity = 1);
    /// A line with round ends.
    void Line(Vec2 a, Vec2 b, float width, RGB color, float opacity = 1);
    void Polyline(std::span<const Vec2> points, float width, RGB color, float opacity = 1);
    void Circle(Vec2 center, float radius, float width, RGB color, float opacity = 1);
    /// A line of text with its baseline at `at`. @param size  height of capitals
    /// @return  its width
    float Text(Vec2 at, float size, RGB color, std::string_view text, Align align = Align::Left,
               bool bold = false);
    static float TextWidth(float size, std::string_view text);

    /// Values are linear sRGB.
    const Image& AsImage() const { return image_; }

  private:
    /// Lays `color` over each pixel of a box as far as coverage(pixel centre) says.
    template <class Coverage>
    void Paint(Vec2 low, Vec2 high, RGB color, float opacity, const Coverage& coverage);

    Image image_;
};

}  // namespace lacquer::plot
