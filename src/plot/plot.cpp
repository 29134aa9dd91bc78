#include "plot/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacquer::plot {

namespace {

constexpr float kSmall = 8.5f, kLabel = 9.5f, kTitle = 12.5f;

/// Mean colour of a hemisphere's pixels that lie under a pixel of the canvas, and how much of it is in the
/// disk.
struct Covered {
    RGB color{0};
    float coverage = 0;
};
Covered Average(const HemispherePlot& plot, Vec2 center, float radius, int x, int y) {
    constexpr int kSub = 4;
    Covered covered;
    for (int j = 0; j < kSub; ++j)
        for (int i = 0; i < kSub; ++i) {
            const Vec2 p((float(x) + (float(i) + 0.5f) / kSub - center.x) / radius,
                         (float(y) + (float(j) + 0.5f) / kSub - center.y) / radius);
            if (glm::dot(p, p) >= 1) continue;
            const auto index = [&](float v) {
                return std::clamp(int((v + 1) / 2 * float(plot.resolution)), 0, plot.resolution - 1);
            };
            covered.color += plot.color(index(p.x), index(p.y));
            covered.coverage += 1;
        }
    if (covered.coverage > 0) covered.color /= covered.coverage;
    covered.coverage /= kSub * kSub;
    return covered;
}

/// Text that can be read on any colours.
void TextOnImage(Canvas& canvas, Vec2 at, RGB color, const std::string& text) {
    canvas.FillRectangle(at.x - 3, at.y - 10, Canvas::TextWidth(kSmall, text) + 6, 13, ColorOf(0x101216),
                         0.7f);
    canvas.Text(at, kSmall, color, text);
}

void DrawTitle(Canvas& canvas, const std::string& title, const std::string& subtitle, Vec2 at) {
    const SheetStyle& style = SheetStyle::Get();
    canvas.Text(at + Vec2(0, 13), kTitle, style.text, title, Align::Left, true);
    canvas.Text(at + Vec2(0, 30), kLabel, style.faint, subtitle);
}

void DrawMark(Canvas& canvas, const PlotMark& mark, Vec2 p, bool dark) {
    const RGB ink = dark ? ColorOf(0x101216) : ColorOf(0xffffff), edge = dark ? ColorOf(0xffffff) : RGB(0);
    if (mark.kind == PlotMark::Kind::Light) {
        canvas.Circle(p, 5, 3.4f, edge, 0.55f);
        canvas.Circle(p, 5, 1.5f, ink);
        canvas.FillCircle(p, 1.6f, ink);
    } else if (mark.kind == PlotMark::Kind::Mirror) {
        for (const Vec2 d : {Vec2(4.5f, 0), Vec2(0, 4.5f)}) {
            canvas.Line(p - d, p + d, 3.4f, edge, 0.75f);
            canvas.Line(p - d, p + d, 1.3f, ink, 0.9f);
        }
    } else {
        const Vec2 corners[] = {p + Vec2(0, -6.5f), p + Vec2(6.5f, 0), p + Vec2(0, 6.5f), p + Vec2(-6.5f, 0),
                                p + Vec2(0, -6.5f)};
        canvas.Polyline(corners, 3.6f, edge, 0.6f);
        canvas.Polyline(corners, 1.7f, SheetStyle::Get().accent);
    }
    if (mark.label.empty()) return;
    // Near the rim the label goes inward.
    const float width = Canvas::TextWidth(kSmall, mark.label);
    const Vec2 at = p + Vec2(mark.at.x > 0.5f ? -10 - width : 10, 3.5f);
    TextOnImage(canvas, at, mark.kind == PlotMark::Kind::Peak ? SheetStyle::Get().accent : ink, mark.label);
}

void DrawAngles(Canvas& canvas, const HemispherePlot& plot, Vec2 center, float radius) {
    const SheetStyle& style = SheetStyle::Get();
    const RGB ink = plot.darkGrid ? ColorOf(0x101216) : ColorOf(0xffffff);
    for (const float thetaDeg : {30.f, 60.f}) {
        const float r = radius * std::sin(Radians(thetaDeg));
        canvas.Circle(center, r, 1, ink, plot.darkGrid ? 0.22f : 0.16f);
        if (plot.labelsAngles)
            TextOnImage(canvas, center + Vec2(0.7071f, 0.7071f) * r + Vec2(4, 10), ink,
                        fmt::format("{}°", thetaDeg));
    }
    canvas.Circle(center, radius, 1.2f, style.faint, 0.9f);
    for (int phi = 0; phi < 360; phi += 15) {
        const Vec2 d(std::cos(Radians(float(phi))), -std::sin(Radians(float(phi))));
        const bool isLong = phi % 90 == 0;
        canvas.Line(center + d * (radius + 2),
                    center + d * (radius + (isLong          ? 8.f
                                            : phi % 30 == 0 ? 6.f
                                                            : 4.f)),
                    1, style.faint, isLong ? 1.f : 0.7f);
        if (!plot.labelsAngles || !isLong) continue;
        const Vec2 p = center + d * (radius + 11);
        const Align align = phi == 0 ? Align::Left : phi == 180 ? Align::Right : Align::Center;
        canvas.Text(p + Vec2(0, phi == 270  ? 8.f
                                : phi == 90 ? 0.f
                                            : 3.5f),
                    kSmall, style.faint, fmt::format("{}°", phi), align);
    }
}

/// The colours of an image with numbers below.
void DrawBar(Canvas& canvas, const HemispherePlot& plot, Vec2 at, float width) {
    const SheetStyle& style = SheetStyle::Get();
    constexpr float kHeight = 9;
    for (int x = 0; x < int(width); ++x)
        canvas.FillRectangle(at.x + float(x), at.y, 1, kHeight,
                             plot.colors->At((double(x) + 0.5) / double(width)));
    const Ticks ticks = TicksOf(plot.scale);
    const auto xOf = [&](double v) { return at.x + float(plot.scale.Position(v)) * width; };
    const float y = at.y + kHeight + 1;
    for (const double v : ticks.all) canvas.Line({xOf(v), y}, {xOf(v), y + 2}, 1, style.faint, 0.8f);
    for (const double v : ticks.labelled) {
        canvas.Line({xOf(v), y}, {xOf(v), y + 4.5f}, 1, style.faint);
        canvas.Text({xOf(v), y + 16}, kSmall, style.faint, ShortNumber(v), Align::Center);
    }
    canvas.Text({at.x, y + 29}, kSmall, style.faint, plot.unit);
    canvas.Text({at.x + width, y + 29}, kSmall, style.faint, plot.note, Align::Right);
}

/// A polyline in dashes of 6 pixels.
void DrawDashed(Canvas& canvas, const std::vector<Vec2>& points, float width, RGB color) {
    constexpr float kDash = 6, kGap = 4;
    float along = 0;
    for (size_t i = 1; i < points.size(); ++i) {
        const Vec2 a = points[i - 1], b = points[i];
        const float length = glm::length(b - a);
        for (float t = 0; t < length;) {
            const float phase = std::fmod(along + t, kDash + kGap);
            const float step = std::min(length - t, (phase < kDash ? kDash : kDash + kGap) - phase + 1e-3f);
            if (phase < kDash)
                canvas.Line(a + (b - a) * (t / length), a + (b - a) * ((t + step) / length), width, color);
            t += step;
        }
        along += length;
    }
}

}  // namespace

const SheetStyle& SheetStyle::Get() {
    static const SheetStyle style;
    return style;
}

RGB SheetStyle::Curve(size_t i) {
    constexpr unsigned kColors[] = {0xf4bd50, 0x58b6f2, 0xf2739c, 0x7fd483,
                                    0xb79cf5, 0xf08f56, 0x58d6cf, 0xd0d34f};
    return ColorOf(kColors[i % std::size(kColors)]);
}

double ValueScale::Position(double value) const {
    if (!isLog) return (value - low) / (high - low);
    if (!(value > 0)) return -1;
    return std::log(value / low) / std::log(high / low);
}

ValueScale LogScaleOf(const std::vector<double>& values) {
    std::vector<double> positive;
    for (const double v : values)
        if (v > 0 && std::isfinite(v)) positive.push_back(v);
    if (positive.empty()) return {0.01, 1, true};
    std::sort(positive.begin(), positive.end());
    const double high = positive.back();
    const double low = positive[size_t(0.02 * double(positive.size()))];
    return {std::clamp(low, high * 1e-5, high * 0.1), high, true};
}

Ticks TicksOf(const ValueScale& scale) {
    Ticks ticks;
    const auto isOn = [&](double v) {
        const double p = scale.Position(v);
        return p > -1e-9 && p < 1 + 1e-9;
    };
    if (!scale.isLog) {
        const double raw = (scale.high - scale.low) / 5, unit = std::pow(10, std::floor(std::log10(raw)));
        const double step = unit * (raw / unit < 1.5 ? 1 : raw / unit < 3.5 ? 2 : raw / unit < 7.5 ? 5 : 10);
        for (double k = std::ceil(scale.low / step - 1e-9); k * step <= scale.high + 1e-9 * step; ++k)
            ticks.all.push_back(k == 0 ? 0 : k * step);
        ticks.labelled = ticks.all;
        return ticks;
    }
    const double decades = std::log10(scale.high / scale.low);
    for (int e = int(std::floor(std::log10(scale.low))); e <= int(std::ceil(std::log10(scale.high))); ++e)
        for (int m = 1; m < 10; ++m) {
            const double v = m * std::pow(10, e);
            if (!isOn(v)) continue;
            ticks.all.push_back(v);
            if (m == 1 || (decades < 2.2 && (m == 2 || m == 5))) ticks.labelled.push_back(v);
        }
    return ticks;
}

std::string ShortNumber(double value) {
    if (value == 0) return "0";
    const double a = std::abs(value);
    if (a < 0.999e-3 || a >= 1e5) {
        const int e = int(std::floor(std::log10(a) + 1e-9));
        const double m = value / std::pow(10, e);
        return std::abs(m - std::round(m)) < 1e-6 ? fmt::format("{:.0f}e{}", m, e)
                                                  : fmt::format("{:.1f}e{}", m, e);
    }
    return fmt::format("{:.4g}", value);
}

void Draw(Canvas& canvas, const HemispherePlot& plot, Vec2 at, float size) {
    DrawTitle(canvas, plot.title, plot.subtitle, at);
    const Vec2 center = at + Vec2(size / 2, kTitleHeight + size / 2);
    const float radius = size / 2 - 14;
    for (int y = int(center.y - radius) - 1; y <= int(center.y + radius) + 1; ++y)
        for (int x = int(center.x - radius) - 1; x <= int(center.x + radius) + 1; ++x) {
            const Covered covered = Average(plot, center, radius, x, y);
            canvas.Blend(x, y, covered.color, covered.coverage);
        }
    DrawAngles(canvas, plot, center, radius);
    for (const PlotMark& mark : plot.marks)
        DrawMark(canvas, mark, center + radius * Vec2(mark.at.x, -mark.at.y), plot.darkGrid);
    if (plot.colors) DrawBar(canvas, plot, at + Vec2(14, kTitleHeight + size + 14), size - 28);
}

namespace {

/// Where the values of a plot of curves stand on the canvas.
struct CurveFrame {
    const CurvePlot& plot;
    Vec2 low, high;  ///< corners: top left, bottom right

    Vec2 At(double x, double y) const {
        return Vec2(low.x + float(plot.x.Position(x)) * (high.x - low.x),
                    high.y - float(plot.y.Position(y)) * (high.y - low.y));
    }
};

void DrawAxes(Canvas& canvas, const CurveFrame& frame) {
    const SheetStyle& style = SheetStyle::Get();
    const CurvePlot& plot = frame.plot;
    const Vec2 low = frame.low, high = frame.high;
    canvas.FillRectangle(low.x, low.y, high.x - low.x, high.y - low.y, style.plate);
    for (const double v : TicksOf(plot.y).labelled) {
        const float y = frame.At(plot.x.low, v).y;
        canvas.Line({low.x, y}, {high.x, y}, 1, style.rule, 0.8f);
        canvas.Text({low.x - 6, y + 3.5f}, kSmall, style.faint, ShortNumber(v), Align::Right);
    }
    for (const double v : plot.xTicks) {
        const float x = frame.At(v, plot.y.low).x;
        canvas.Line({x, low.y}, {x, high.y}, 1, style.rule, 0.8f);
        canvas.Text({x, high.y + 15}, kSmall, style.faint, fmt::format("{}°", v), Align::Center);
    }
    canvas.Text({(low.x + high.x) / 2, high.y + 31}, kSmall, style.faint, plot.xLabel, Align::Center);
    for (const auto& [x, label] : plot.lines) {
        const Vec2 p = frame.At(x, plot.y.low);
        canvas.Line({p.x, low.y}, {p.x, high.y}, 1, style.accent, 0.7f);
        canvas.Text({p.x + 4, low.y + 11}, kSmall, style.accent, label);
    }
}

/// The line through points in the style of a curve, if it is one. Dashes are opaque.
void DrawLine(Canvas& canvas, const Curve& curve, const std::vector<Vec2>& points, float opacity) {
    if (!curve.isLine) return;
    if (curve.isDashed) return DrawDashed(canvas, points, curve.width, curve.color);
    for (size_t i = 1; i < points.size(); ++i)
        canvas.Line(points[i - 1], points[i], curve.width, curve.color, opacity);
}

/// Clipped to the frame by leaving out what is off the scale.
void DrawCurve(Canvas& canvas, const CurveFrame& frame, const Curve& curve) {
    std::vector<Vec2> run;
    const auto finish = [&] {
        DrawLine(canvas, curve, run, curve.opacity);
        run.clear();
    };
    for (size_t i = 0; i < curve.points.size(); ++i) {
        const Vec2 v = curve.points[i];
        const double position = frame.plot.y.Position(double(v.y));
        if (!(position >= 0 && position <= 1.02)) {
            finish();
            continue;
        }
        const Vec2 p = frame.At(double(v.x), double(v.y));
        run.push_back(p);
        if (!curve.errors.empty()) {
            const float reach = std::abs(frame.At(0, double(v.y + 2 * curve.errors[i])).y - p.y);
            canvas.Line(p - Vec2(0, reach), p + Vec2(0, reach), 1.2f, curve.color);
        }
        if (curve.hasDots) canvas.FillCircle(p, curve.width, curve.color);
    }
    finish();
}

constexpr float kLegendRow = 14;

/// In rows above the frame, the lowest next to it. @return  how many they are; with 0 for `rows` nothing is
/// drawn
int DrawLegend(Canvas& canvas, const CurveFrame& frame, int rows) {
    float x = frame.low.x;
    int row = 0;
    for (const Curve& curve : frame.plot.curves) {
        if (curve.label.empty()) continue;
        const float width = 21 + canvas.TextWidth(kSmall, curve.label);
        if (x > frame.low.x && x + width > frame.high.x) {
            x = frame.low.x;
            ++row;
        }
        const float y = frame.low.y - 7 - kLegendRow * float(rows - 1 - row);
        if (rows > 0) {
            const Vec2 a(x, y - 3), b(x + 16, y - 3);
            DrawLine(canvas, curve, {a, b}, 1);
            if (curve.hasDots) canvas.FillCircle((a + b) / 2.f, std::max(2.f, curve.width), curve.color);
            canvas.Text({x + 21, y}, kSmall, SheetStyle::Get().text, curve.label);
        }
        x += width + 16;
    }
    return row + 1;
}

}  // namespace

void Draw(Canvas& canvas, const CurvePlot& plot, Vec2 at, Vec2 size) {
    DrawTitle(canvas, plot.title, plot.subtitle, at);
    CurveFrame frame{plot, at + Vec2(46, kTitleHeight + 20), at + size - Vec2(10, 36)};
    const int rows = DrawLegend(canvas, frame, 0);
    frame.low.y += kLegendRow * float(rows - 1);
    DrawAxes(canvas, frame);
    for (const Curve& curve : plot.curves) DrawCurve(canvas, frame, curve);
    DrawLegend(canvas, frame, rows);
}

}  // namespace lacquer::plot
