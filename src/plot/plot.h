// Parts of the contact sheet: hemispheres, colour bars, curves.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "plot/canvas.h"

namespace lacquer::plot {

/// The colours of the sheet.
struct SheetStyle {
    RGB background = ColorOf(0x15171c), plate = ColorOf(0x1d2027), rule = ColorOf(0x3a3f4a);
    RGB text = ColorOf(0xeae7e0), faint = ColorOf(0x9aa1ad), accent = ColorOf(0xf4bd50);
    RGB missing = ColorOf(0x353a44);  ///< where there are too few samples
    static const SheetStyle& Get();
    /// Well distinguishable colours for curves, in order.
    static RGB Curve(size_t i);
};

/// From values to positions on a scale.
struct ValueScale {
    double low = 0, high = 1;
    bool isLog = false;
    /// 0 at `low`, 1 at `high`; values off the scale give values outside.
    double Position(double value) const;
};
/// Room for numbers up to `high`, over as many decades as `values` fill, 1 to 5 of them.
ValueScale LogScaleOf(const std::vector<double>& values);
/// Numbers for the ticks of a scale, and fewer that get labels.
struct Ticks {
    std::vector<double> all, labelled;
};
Ticks TicksOf(const ValueScale& scale);
/// "0.01", "30", "1e-5".
std::string ShortNumber(double value);

/// A point of interest in a hemisphere.
struct PlotMark {
    enum class Kind { Light, Mirror, Peak };
    Kind kind = Kind::Mirror;
    Vec2 at{0};  ///< in the unit disk, y upward
    std::string label;
};

/// An image over the projected hemisphere with rings at 30, 60 and 90 degrees and ticks of azimuth.
struct HemispherePlot {
    std::string title, subtitle;
    /// The colour of pixel (x, y) of `resolution` squared, rows from the top.
    std::function<RGB(int x, int y)> color;
    int resolution = 1;
    bool darkGrid = false;               ///< for bright images
    const ColorScale* colors = nullptr;  ///< of the bar below; null: no bar
    ValueScale scale;
    std::string unit;
    std::string note;  ///< at the end of the bar
    bool labelsAngles = false;
    std::vector<PlotMark> marks;
};
/// @param at  top left corner    @param size  width; the height is kTitleHeight + size + kBarHeight
void Draw(Canvas& canvas, const HemispherePlot& plot, Vec2 at, float size);
/// Height of the title and the subtitle above an image, and of the colour bar below it.
inline constexpr float kTitleHeight = 40, kBarHeight = 50;

struct Curve {
    std::vector<Vec2> points;   ///< in units of the axes
    std::vector<float> errors;  ///< standard errors, or none
    RGB color{1};
    float width = 1.6f;
    float opacity = 1;
    bool isDashed = false, isLine = true, hasDots = false;
    std::string label;  ///< in the legend; empty: none
};

/// Curves over two axes.
struct CurvePlot {
    std::string title, subtitle, xLabel;
    ValueScale x, y;
    std::vector<double> xTicks;
    std::vector<Curve> curves;
    /// Vertical lines with a label.
    std::vector<std::pair<double, std::string>> lines;
};
void Draw(Canvas& canvas, const CurvePlot& plot, Vec2 at, Vec2 size);

}  // namespace lacquer::plot
