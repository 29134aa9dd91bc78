#include "plot/canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lacquer::plot {

namespace {

/// Distance of p from the segment ab.
float SegmentDistance(Vec2 p, Vec2 a, Vec2 b) {
    const Vec2 d = b - a;
    const float length2 = glm::dot(d, d);
    const float t = length2 > 0 ? std::clamp(glm::dot(p - a, d) / length2, 0.f, 1.f) : 0.f;
    return glm::length(p - (a + t * d));
}

/// Part of a pixel that lies inside of an edge at this signed distance (negative: inside).
float EdgeCoverage(float distance) { return std::clamp(0.5f - distance, 0.f, 1.f); }

double Cube(double x) { return x * x * x; }

/// Linear sRGB of an OKLab colour; components outside of [0,1] are colours that sRGB lacks.
glm::dvec3 LinearFromOklab(glm::dvec3 lab) {
    const double l = Cube(lab.x + 0.3963377774 * lab.y + 0.2158037573 * lab.z);
    const double m = Cube(lab.x - 0.1055613458 * lab.y - 0.0638541728 * lab.z);
    const double s = Cube(lab.x - 0.0894841775 * lab.y - 1.2914855480 * lab.z);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

bool IsInGamut(glm::dvec3 rgb) {
    const auto inside = [](double x) { return x >= -1e-6 && x <= 1 + 1e-6; };
    return inside(rgb.x) && inside(rgb.y) && inside(rgb.z);
}

/// The colour of this lightness, chroma and hue [degrees], with less chroma where sRGB has not enough.
RGB FromLightnessChromaHue(Vec3 lch) {
    const double hue = double(lch.z) * double(Pi) / 180;
    const auto at = [&](double chroma) {
        return LinearFromOklab({double(lch.x), chroma * std::cos(hue), chroma * std::sin(hue)});
    };
    double low = 0, high = double(lch.y);
    if (IsInGamut(at(high))) low = high;
    for (int i = 0; i < 30 && low < high; ++i) {
        const double middle = (low + high) / 2;
        (IsInGamut(at(middle)) ? low : high) = middle;
    }
    return RGB(glm::clamp(at(low), 0.0, 1.0));
}

/// Piecewise linear through points (t, value), in the order of t.
double Interpolate(std::span<const glm::dvec2> points, double t) {
    for (size_t i = 1; i < points.size(); ++i)
        if (t <= points[i].x) {
            const double f = (t - points[i - 1].x) / (points[i].x - points[i - 1].x);
            return points[i - 1].y + std::max(0.0, f) * (points[i].y - points[i - 1].y);
        }
    return points.back().y;
}

}  // namespace

RGB ColorOf(unsigned hex) {
    const ColorEncoding srgb{ColorEncoding::Kind::SRGB, 1};
    const auto channel = [&](int shift) { return srgb.ToLinear(float((hex >> shift) & 255) / 255); };
    return {channel(16), channel(8), channel(0)};
}

Vec3 OklabFromLinear(RGB rgb) {
    const glm::dvec3 c(rgb);
    const double l = std::cbrt(0.4122214708 * c.x + 0.5363325363 * c.y + 0.0514459929 * c.z);
    const double m = std::cbrt(0.2119034982 * c.x + 0.6806995451 * c.y + 0.1073969566 * c.z);
    const double s = std::cbrt(0.0883024619 * c.x + 0.2817188376 * c.y + 0.6299787005 * c.z);
    return Vec3(glm::dvec3(0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
                           1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
                           0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s));
}

ColorScale::ColorScale(const std::function<Vec3(double)>& oklch) {
    constexpr int kSteps = 512;
    for (int i = 0; i <= kSteps; ++i) colors_.push_back(FromLightnessChromaHue(oklch(double(i) / kSteps)));
}

const ColorScale& ColorScale::Sequential() {
    static const ColorScale scale([](double t) {
        const glm::dvec2 chroma[] = {{0, 0.02}, {0.2, 0.13}, {0.45, 0.19}, {0.7, 0.17}, {1, 0.075}};
        const glm::dvec2 hue[] = {{0, 285}, {0.25, 300}, {0.5, 367}, {0.7, 410}, {1, 464}};
        return Vec3(glm::dvec3(0.14 + 0.835 * t, Interpolate(chroma, t), Interpolate(hue, t)));
    });
    return scale;
}

const ColorScale& ColorScale::Diverging() {
    static const ColorScale scale([](double t) {
        const double side = std::abs(2 * t - 1);
        const double chroma = 0.20 * std::pow(side, 0.85);
        return Vec3(glm::dvec3(0.95 - 0.52 * side, chroma, t < 0.5 ? 257 : 25));
    });
    return scale;
}

RGB ColorScale::At(double t) const {
    const double last = double(colors_.size() - 1);
    const double x = t > 0 ? std::min(t, 1.0) * last : 0;
    const size_t i = std::min(size_t(x), colors_.size() - 2);
    return glm::mix(colors_[i], colors_[i + 1], float(x - double(i)));
}

Canvas::Canvas(int width, int height, RGB background) : image_({width, height}, {"R", "G", "B"}) {
    for (size_t i = 0; i < image_.Pixels().size(); ++i) image_.Pixels()[i] = background[int(i % 3)];
}

void Canvas::Blend(int x, int y, RGB color, float coverage) {
    if (x < 0 || y < 0 || x >= Width() || y >= Height() || !(coverage > 0)) return;
    for (int c = 0; c < 3; ++c) image_.Set({x, y}, c, Lerp(coverage, image_.Get({x, y}, c), color[c]));
}

template <class Coverage>
void Canvas::Paint(Vec2 low, Vec2 high, RGB color, float opacity, const Coverage& coverage) {
    const int x0 = std::max(0, int(std::floor(low.x))), x1 = std::min(Width() - 1, int(std::ceil(high.x)));
    const int y0 = std::max(0, int(std::floor(low.y))), y1 = std::min(Height() - 1, int(std::ceil(high.y)));
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x)
            Blend(x, y, color, opacity * coverage(Vec2(float(x) + 0.5f, float(y) + 0.5f)));
}

void Canvas::FillRectangle(float x, float y, float width, float height, RGB color, float opacity) {
    const auto overlap = [](float at, float from, float to) {
        return std::clamp(std::min(at + 0.5f, to) - std::max(at - 0.5f, from), 0.f, 1.f);
    };
    Paint({x, y}, {x + width, y + height}, color, opacity,
          [&](Vec2 p) { return overlap(p.x, x, x + width) * overlap(p.y, y, y + height); });
}

void Canvas::FillCircle(Vec2 center, float radius, RGB color, float opacity) {
    const Vec2 reach(radius + 1);
    Paint(center - reach, center + reach, color, opacity,
          [&](Vec2 p) { return EdgeCoverage(glm::length(p - center) - radius); });
}

void Canvas::Line(Vec2 a, Vec2 b, float width, RGB color, float opacity) {
    const Vec2 reach(width / 2 + 1);
    Paint(glm::min(a, b) - reach, glm::max(a, b) + reach, color, opacity,
          [&](Vec2 p) { return EdgeCoverage(SegmentDistance(p, a, b) - width / 2); });
}

void Canvas::Polyline(std::span<const Vec2> points, float width, RGB color, float opacity) {
    if (points.empty()) return;
    // One coverage for the whole line, or its joints would be painted twice.
    Vec2 low = points[0], high = points[0];
    for (const Vec2 p : points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const Vec2 reach(width / 2 + 1);
    Paint(low - reach, high + reach, color, opacity, [&](Vec2 p) {
        float nearest = glm::length(p - points[0]);
        for (size_t i = 1; i < points.size(); ++i)
            nearest = std::min(nearest, SegmentDistance(p, points[i - 1], points[i]));
        return EdgeCoverage(nearest - width / 2);
    });
}

void Canvas::Circle(Vec2 center, float radius, float width, RGB color, float opacity) {
    const Vec2 reach(radius + width / 2 + 1);
    Paint(center - reach, center + reach, color, opacity,
          [&](Vec2 p) { return EdgeCoverage(std::abs(glm::length(p - center) - radius) - width / 2); });
}

float Canvas::Text(Vec2 at, float size, RGB color, std::string_view text, Align align, bool bold) {
    const float scale = size / StrokeFont::kCapitalHeight;
    const float pen = std::max(1.1f, (bold ? 1.25f : 0.85f) * scale);
    const float width = TextWidth(size, text);
    float x = at.x - (align == Align::Left ? 0 : align == Align::Center ? width / 2 : width);
    for (const char32_t c : DecodeUtf8(text)) {
        const StrokeFont::Glyph& glyph = StrokeFont::Plain().Find(c);
        // Strokes of one glyph that touch must not add up: the nearest one counts.
        std::vector<std::vector<Vec2>> strokes = glyph.strokes;
        Vec2 low(Infinity), high(-Infinity);
        for (auto& stroke : strokes)
            for (Vec2& p : stroke) {
                p = Vec2(x, at.y) + scale * Vec2(p.x, -p.y);
                low = glm::min(low, p);
                high = glm::max(high, p);
            }
        if (!strokes.empty())
            Paint(low - Vec2(pen), high + Vec2(pen), color, 1, [&](Vec2 p) {
                float nearest = Infinity;
                for (const auto& stroke : strokes)
                    for (size_t i = 0; i + 1 < stroke.size(); ++i)
                        nearest = std::min(nearest, SegmentDistance(p, stroke[i], stroke[i + 1]));
                return EdgeCoverage(nearest - pen / 2);
            });
        x += scale * glyph.advance;
    }
    return width;
}

float Canvas::TextWidth(float size, std::string_view text) {
    float width = 0;
    for (const char32_t c : DecodeUtf8(text)) width += StrokeFont::Plain().Find(c).advance;
    return width * size / StrokeFont::kCapitalHeight;
}

}  // namespace lacquer::plot
