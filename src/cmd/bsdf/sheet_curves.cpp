// Curves of the contact sheet.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cmd/bsdf/sheet_parts.h"

namespace lacquer::cmd {

using namespace measure;
using namespace plot;

namespace {

class CurveMaker {
  public:
    explicit CurveMaker(const BsdfResult& result) : r_(result) {}

    CurvePlot Section(const SheetSide& side) const {
        CurvePlot plot;
        plot.title = fmt::format("{} in the plane of incidence", side.name);
        plot.subtitle = "f cos θ [1/sr]; negative angles lie on the side of the light";
        plot.xLabel = "angle to the normal";
        plot.x = {-90, 90, false};
        plot.xTicks = {-90, -60, -30, 0, 30, 60, 90};
        plot.y = LogScaleOf(RangeOf(side.Of(r_.estimators[0].lobe), r_.isStochastic));
        plot.y.high *= 1.5;
        Curve samples;
        samples.points = SectionOf(side.Of(r_.histogram));
        samples.isLine = false;
        samples.hasDots = true;
        samples.width = 1.5f;
        samples.color = style_.faint;
        samples.label = "samples";
        plot.curves.push_back(samples);
        // The noisiest lies at the bottom.
        std::vector<size_t> order(r_.estimators.size());
        std::iota(order.begin(), order.end(), size_t(0));
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
            return side.DifferenceOf(r_.estimators[a]).medianNoise >
                   side.DifferenceOf(r_.estimators[b]).medianNoise;
        });
        for (const size_t i : order) {
            Curve curve;
            curve.points = SectionOf(side.Of(r_.estimators[i].lobe));
            curve.color = SheetStyle::Curve(i);
            if (i != order.back()) curve.opacity = 0.65f;
            curve.label = r_.estimators[i].name;
            plot.curves.push_back(curve);
        }
        if (!side.isTransmission) plot.lines.push_back({-std::min(r_.thetaDeg, 180 - r_.thetaDeg), "ωi"});
        return plot;
    }

    CurvePlot Albedo() const {
        CurvePlot plot;
        plot.title = "Albedo by angle";
        plot.subtitle =
            "all light that leaves again: RGB by samples; luminance of the furnace and of estimators (95 % "
            "bars)";
        plot.x = {0, 90, false};
        plot.xTicks = {0, 15, 30, 45, 60, 75, 90};
        double most = 0.05;
        const RGB primaries[] = {ColorOf(0xf2695c), ColorOf(0x74d07c), ColorOf(0x5f9df5)};
        const char* names[] = {"red", "green", "blue"};
        for (const SheetSide& side : SidesOf(r_))
            for (int c = 0; c < 3; ++c) {
                Curve curve;
                curve.color = primaries[c];
                curve.isDashed = side.isTransmission;
                curve.width = 2;
                if (!side.isTransmission) curve.label = names[c];
                for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
                    const double v = side.AllOf(r_.sampledByAngle[i]).Mean()[c];
                    curve.points.push_back(Vec2(glm::dvec2(r_.anglesDeg[i], v)));
                    most = std::max(most, v);
                }
                plot.curves.push_back(curve);
            }
        Curve furnace;
        furnace.color = style_.text;
        furnace.width = 1.2f;
        furnace.label = "white furnace";
        for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
            const SampledLobe& s = r_.sampledFurnaceByAngle[i];
            const double v = s.reflected.Luminance() + s.transmitted.Luminance();
            furnace.points.push_back(Vec2(glm::dvec2(r_.anglesDeg[i], v)));
            most = std::max(most, v);
        }
        plot.curves.push_back(furnace);
        AddEstimatorDots(plot);
        plot.y = {0, std::min(1.1, most * 1.12), false};
        if (most > 1.05) plot.y.high = most * 1.05;
        plot.xLabel =
            r_.transmits ? "angle of incidence; reflected solid, transmitted dashed" : "angle of incidence";
        return plot;
    }

    void Swatches(Canvas& canvas, Vec2 at, float width) const {
        float y = at.y;
        for (const SheetSide& side : SidesOf(r_)) {
            const float height = r_.transmits ? 14 : 26;
            for (int x = 0; x < int(width); ++x) {
                const double thetaDeg = 90 * (x + 0.5) / double(width);
                const auto it = std::upper_bound(r_.anglesDeg.begin(), r_.anglesDeg.end(), thetaDeg);
                const size_t i =
                    std::clamp<size_t>(size_t(it - r_.anglesDeg.begin()), 1, r_.anglesDeg.size() - 1);
                const double t = std::clamp(
                    (thetaDeg - r_.anglesDeg[i - 1]) / (r_.anglesDeg[i] - r_.anglesDeg[i - 1]), 0.0, 1.0);
                const glm::dvec3 color = glm::mix(side.AllOf(r_.sampledByAngle[i - 1]).Mean(),
                                                  side.AllOf(r_.sampledByAngle[i]).Mean(), t);
                canvas.FillRectangle(at.x + float(x), y, 1, height, glm::clamp(RGB(color), 0.f, 1.f));
            }
            canvas.Text({at.x - 8, y + height / 2 + 3.5f}, 8.5f, style_.faint,
                        side.isTransmission ? "T" : "R", Align::Right);
            y += height + 3;
        }
    }

  private:
    /// Values along the line through wi and the centre, means over a strip of five pixels across; negative
    /// angles on the light's side.
    std::vector<Vec2> SectionOf(const LobeImage& image) const {
        const double phi = r_.phiDeg * double(Pi) / 180;
        const glm::dvec2 along(-std::cos(phi), -std::sin(phi)), across(std::sin(phi), -std::cos(phi));
        const int n = image.resolution;
        std::vector<Vec2> points;
        for (double thetaDeg = -89.5; thetaDeg < 90; thetaDeg += 0.5) {
            double sum = 0, count = 0;
            for (int k = -2; k <= 2; ++k) {
                const glm::dvec2 p =
                    std::sin(thetaDeg * double(Pi) / 180) * along + (2.0 * k / double(n)) * across;
                if (glm::length(p) > 1 - 2.0 / n) continue;  // pixels at the rim are mixed with black
                sum += Interpolated(image, (1 + p.x) / 2 * n - 0.5, (1 - p.y) / 2 * n - 0.5);
                ++count;
            }
            if (count > 0) points.push_back(Vec2(glm::dvec2(thetaDeg, sum / count)));
        }
        return points;
    }

    /// Bilinear luminance at pixel coordinates whose whole numbers are pixel centres.
    static double Interpolated(const LobeImage& image, double x, double y) {
        const int n = image.resolution;
        const int x0 = std::clamp(int(std::floor(x)), 0, n - 2),
                  y0 = std::clamp(int(std::floor(y)), 0, n - 2);
        const double fx = std::clamp(x - x0, 0.0, 1.0), fy = std::clamp(y - y0, 0.0, 1.0);
        const auto at = [&](int dx, int dy) {
            return image.LuminanceAt(size_t(y0 + dy) * size_t(n) + size_t(x0 + dx));
        };
        return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
    }

    /// Luminance of what each estimator finds, with what is specular added from the samples.
    void AddEstimatorDots(CurvePlot& plot) const {
        for (size_t e = 0; e < r_.estimators.size(); ++e)
            for (const SheetSide& side : SidesOf(r_)) {
                Curve dots;
                dots.color = SheetStyle::Curve(e);
                dots.isLine = false;
                dots.hasDots = true;
                dots.width = 2.4f;
                if (!side.isTransmission) dots.label = r_.estimators[e].name;
                const double shift = 0.7 * (double(e) - double(r_.estimators.size() - 1) / 2);
                for (size_t i = 0; i < r_.anglesDeg.size(); ++i) {
                    const ColorMean& m = side.Of(r_.estimators[e].energyByAngle[i]);
                    const SampledLobe& s = r_.sampledByAngle[i];
                    const double specular = side.AllOf(s).Luminance() - side.SmoothOf(s).Luminance();
                    dots.points.push_back(
                        Vec2(glm::dvec2(r_.anglesDeg[i] + shift, m.Luminance() + specular)));
                    dots.errors.push_back(float(m.LuminanceError()));
                }
                plot.curves.push_back(dots);
            }
    }

    const BsdfResult& r_;
    const SheetStyle& style_ = SheetStyle::Get();
};

}  // namespace

std::vector<SheetSide> SidesOf(const BsdfResult& result) {
    std::vector<SheetSide> sides{{false, "Reflection"}};
    if (result.transmits) sides.push_back({true, "Transmission"});
    return sides;
}

std::vector<double> RangeOf(const LobeImage& image, bool isNoisy) {
    const int n = image.resolution, reach = isNoisy ? 1 : 0;
    std::vector<double> values;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            double sum = 0;
            int count = 0;
            for (int v = std::max(0, y - reach); v <= std::min(n - 1, y + reach); ++v)
                for (int u = std::max(0, x - reach); u <= std::min(n - 1, x + reach); ++u, ++count)
                    sum += image.LuminanceAt(size_t(v) * size_t(n) + size_t(u));
            values.push_back(sum / count);
        }
    return values;
}

CurvePlot SectionPlot(const BsdfResult& result, const SheetSide& side) {
    return CurveMaker(result).Section(side);
}

CurvePlot AlbedoPlot(const BsdfResult& result) { return CurveMaker(result).Albedo(); }

void DrawSwatches(Canvas& canvas, const BsdfResult& result, Vec2 at, float width) {
    CurveMaker(result).Swatches(canvas, at, width);
}

}  // namespace lacquer::cmd
