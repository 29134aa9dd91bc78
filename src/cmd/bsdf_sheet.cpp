#include "cmd/bsdf_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "cmd/bsdf_plot.h"

namespace lacquer {

namespace {

constexpr float kPanel = 320, kGap = 26, kMargin = 36, kHeader = 92;
constexpr float kRowHeight = kTitleHeight + kPanel + kBarHeight + 22;
constexpr float kPlotHeight = 380;
constexpr double kSigmaRange = 4, kRatioRange = 3;
constexpr const char* kTooFew = "grey: too few samples";

/// Something that stands in a row.
struct Cell {
    float width = 0;
    std::function<void(Canvas&, Vec2)> draw;
};
using Row = std::vector<Cell>;

std::string Degrees(double v) { return fmt::format("{:.4g}°", v); }

std::string EnergyText(const ColorMean& m) {
    return fmt::format("energy {:.4f} ± {:.1g}", m.Luminance(), m.LuminanceError());
}

/// One side of the surface, seen from above (transmission as if through the surface).
struct Side {
    bool isTransmission = false;
    const char* name;

    const LobeImage& Of(const LobePair& p) const { return isTransmission ? p.transmission : p.reflection; }
    const std::vector<double>& Of(const DensityPair& p) const {
        return isTransmission ? p.transmission : p.reflection;
    }
    const Difference& DifferenceOf(const EstimatorResult& e) const {
        return isTransmission ? e.transmission : e.reflection;
    }
    const ColorMean& Of(const LobeEnergy& e) const { return isTransmission ? e.transmitted : e.reflected; }
    const ColorMean& SmoothOf(const SampledLobe& s) const {
        return isTransmission ? s.smoothTransmitted : s.smoothReflected;
    }
    const ColorMean& AllOf(const SampledLobe& s) const {
        return isTransmission ? s.transmitted : s.reflected;
    }
};

class SheetMaker {
  public:
    explicit SheetMaker(const BsdfResult& result) : r_(result) {}

    Image Make() {
        std::vector<std::pair<std::string, std::vector<Row>>> sections;
        for (const Side& side : Sides()) sections.push_back({side.name, RowsOf(side)});
        const std::vector<Row> plots = PlotRows();
        // Measure, then draw.
        float width = 900, height = kHeader;
        for (auto& [name, rows] : sections) {
            height += 34;
            for (const Row& row : rows) {
                width = std::max(width, WidthOf(row));
                height += kRowHeight;
            }
        }
        for (const Row& row : plots) width = std::max(width, WidthOf(row));
        height += 34 + float(plots.size()) * (kPlotHeight + 16) + TableHeight() + 30;
        Canvas canvas(int(width + 2 * kMargin), int(height), style_.background);
        float y = DrawHeader(canvas);
        for (auto& [name, rows] : sections) {
            y = DrawSectionTitle(canvas, name, y);
            for (const Row& row : rows) {
                DrawRow(canvas, row, y);
                y += kRowHeight;
            }
        }
        y = DrawSectionTitle(canvas, "Sections, albedo and numbers", y);
        for (const Row& row : plots) {
            DrawRow(canvas, row, y);
            y += kPlotHeight + 16;
        }
        DrawTable(canvas, y + 8);
        return canvas.Picture();
    }

  private:
    std::vector<Side> Sides() const {
        std::vector<Side> sides{{false, "Reflection"}};
        if (r_.transmits) sides.push_back({true, "Transmission"});
        return sides;
    }

    static float WidthOf(const Row& row) {
        float width = 0;
        for (const Cell& cell : row) width += cell.width + kGap;
        return width - kGap;
    }
    static void DrawRow(Canvas& canvas, const Row& row, float y) {
        float x = kMargin;
        for (const Cell& cell : row) {
            cell.draw(canvas, {x, y});
            x += cell.width + kGap;
        }
    }

    float DrawHeader(Canvas& canvas) const {
        const float end =
            kMargin + canvas.Text({kMargin, 46}, 20, style_.text, r_.material, Align::Left, true);
        canvas.Text({end + 14, 46}, 13, style_.faint, fmt::format("{} in {}", r_.type, r_.scene));
        const std::string pdf = r_.pdfName.empty() ? "" : fmt::format("  ·  pdf {}", r_.pdfName);
        canvas.Text(
            {kMargin, 72}, 10.5f, style_.faint,
            fmt::format("light from ωi = (θ {}, φ {})  ·  f cos θ of the outgoing direction, seen from "
                        "above  ·  uv ({:.3g}, {:.3g}){}  ·  {} samples a pixel, {:.3g} million in "
                        "histograms",
                        Degrees(r_.thetaDeg), Degrees(r_.phiDeg), r_.uv.x, r_.uv.y, pdf, r_.samplesPerPixel,
                        double(r_.histogramSamples) * 1e-6));
        return kHeader;
    }

    float DrawSectionTitle(Canvas& canvas, const std::string& title, float y) const {
        const float width = canvas.Text({kMargin, y + 16}, 14, style_.accent, title, Align::Left, true);
        canvas.Line({kMargin + width + 14, y + 10}, {float(canvas.Width()) - kMargin, y + 10}, 1,
                    style_.rule);
        return y + 34;
    }

    /// What to point out on one side.
    std::vector<PlotMark> MarksOf(const Side& side, bool withLabels) const {
        const Vec2 w(r_.w.x, r_.w.y);
        std::vector<PlotMark> marks;
        if (!side.isTransmission) marks.push_back({PlotMark::Kind::Light, w, withLabels ? "ωi" : ""});
        marks.push_back({PlotMark::Kind::Mirror, -w, ""});
        for (const SpecularPeak& peak : r_.sampled.peaks) {
            if (SameHemisphere(peak.w, r_.w) == side.isTransmission) continue;
            const std::string label =
                withLabels ? fmt::format("specular {:.3f}", Luminance(peak.energy)) : std::string();
            marks.push_back({PlotMark::Kind::Peak, {peak.w.x, peak.w.y}, label});
        }
        return marks;
    }

    Cell Hemisphere(HemispherePlot plot) const {
        return {kPanel,
                [plot = std::move(plot)](Canvas& canvas, Vec2 at) { Draw(canvas, plot, at, kPanel); }};
    }

    /// A picture of numbers on a scale.
    HemispherePlot Mapped(const std::string& title, const std::string& subtitle, int resolution,
                          const ValueScale& scale, const ColorScale& colors, const std::string& unit,
                          std::function<double(size_t)> value) const {
        HemispherePlot plot;
        plot.scale = scale;
        plot.colors = &colors;
        plot.unit = unit;
        plot.title = title;
        plot.subtitle = subtitle;
        plot.resolution = resolution;
        plot.color = [=, &colors, missing = style_.missing](int x, int y) {
            const double v = value(size_t(y) * size_t(resolution) + size_t(x));
            return std::isnan(v) ? missing : colors.At(scale.Position(v));
        };
        return plot;
    }

    std::vector<Row> RowsOf(const Side& side) const {
        Row lobes = LobeCells(side), differences = DifferenceCells(side);
        std::vector<Row> rows;
        if (r_.estimators.size() == 1) {
            lobes.insert(lobes.end(), differences.begin(), differences.end());
            rows = Wrap(lobes);
        } else {
            rows = Wrap(lobes);
            for (Row& row : Wrap(differences)) rows.push_back(std::move(row));
        }
        rows.push_back(DensityCells(side));
        return rows;
    }

    /// Rows of at most five pictures.
    static std::vector<Row> Wrap(const Row& cells) {
        constexpr int kMost = 5;
        std::vector<Row> rows(1);
        for (const Cell& cell : cells) {
            if (rows.back().size() == kMost) rows.emplace_back();
            rows.back().push_back(cell);
        }
        return rows;
    }

    static std::vector<double> Luminances(const LobeImage& image) {
        std::vector<double> values;
        for (size_t i = 0; i < image.value.size(); ++i) values.push_back(image.LuminanceAt(i));
        return values;
    }

    Row LobeCells(const Side& side) const {
        const ValueScale scale = LogScaleOf(Luminances(side.Of(r_.estimators[0].lobe)));
        const ColorScale& colors = ColorScale::Sequential();
        Row cells;
        for (const EstimatorResult& e : r_.estimators) {
            const LobeImage& image = side.Of(e.lobe);
            HemispherePlot plot =
                Mapped(e.name, EnergyText(side.Of(e.energy)), image.resolution, scale, colors,
                       "f cos θ [1/sr]", [&image](size_t i) { return image.LuminanceAt(i); });
            plot.labelsAngles = cells.empty();
            plot.marks = MarksOf(side, cells.empty());
            cells.push_back(Hemisphere(std::move(plot)));
        }
        const LobeImage& histogram = side.Of(r_.histogram);
        HemispherePlot plot = Mapped("histogram of Sample()", EnergyText(side.SmoothOf(r_.sampled)),
                                     histogram.resolution, scale, colors, "f cos θ [1/sr]",
                                     [&histogram](size_t i) { return histogram.LuminanceAt(i); });
        plot.marks = MarksOf(side, false);
        cells.push_back(Hemisphere(std::move(plot)));
        return cells;
    }

    Row DifferenceCells(const Side& side) const {
        const ValueScale scale{-kSigmaRange, kSigmaRange, false};
        const ColorScale& colors = ColorScale::Diverging();
        Row cells;
        for (const EstimatorResult& e : r_.estimators) {
            const Difference& d = side.DifferenceOf(e);
            HemispherePlot plot =
                Mapped(fmt::format("{} − histogram", e.name),
                       fmt::format("rms {:.2f} σ in {} blocks (noise alone: 1)  ·  σ = {:.2g} %", d.rms,
                                   d.numBlocks, 100 * d.medianNoise),
                       d.resolution, scale, colors, "standard errors σ of the difference",
                       [&d](size_t i) { return d.sigmas[i]; });
            plot.note = kTooFew;
            plot.darkGrid = true;
            cells.push_back(Hemisphere(std::move(plot)));
        }
        cells.push_back(ColorCell(side));
        return cells;
    }

    /// The lobe as colours, compressed so that peak and tail both show.
    Cell ColorCell(const Side& side) const {
        const LobeImage& image = side.Of(r_.estimators[0].lobe);
        const std::vector<double> values = Luminances(image);
        const double peak = std::max(1e-12, *std::max_element(values.begin(), values.end()));
        HemispherePlot plot;
        plot.title = "in colour";
        plot.subtitle = "log(1 + 100 x) of the luminance x over its peak";
        plot.resolution = image.resolution;
        plot.color = [&image, peak](int x, int y) {
            const size_t i = size_t(y) * size_t(image.resolution) + size_t(x);
            const double luminance = std::max(1e-12, image.LuminanceAt(i));
            const double shown = std::log1p(100 * luminance / peak) / std::log(101.0);
            return glm::clamp(RGB(image.value[i] * (0.9 * shown * shown / luminance)), 0.f, 1.f);
        };
        return Hemisphere(std::move(plot));
    }

    Row DensityCells(const Side& side) const {
        const std::vector<double>&pdf = side.Of(r_.pdf), &density = side.Of(r_.density);
        const int resolution = r_.resolution;
        std::vector<double> both = pdf;
        both.insert(both.end(), density.begin(), density.end());
        const ValueScale scale = LogScaleOf(both);
        const ColorScale& colors = ColorScale::Sequential();
        Row cells;
        cells.push_back(Hemisphere(Mapped("pdf", "what Evaluate() says about Sample()", resolution, scale,
                                          colors, "[1/sr]", [&pdf](size_t i) { return pdf[i]; })));
        cells.push_back(
            Hemisphere(Mapped("density of Sample()", "histogram of its directions, not weighted", resolution,
                              scale, colors, "[1/sr]", [&density](size_t i) { return density[i]; })));
        // The ratio over blocks, where the histogram has enough samples to mean something.
        const int size = std::max(1, resolution / 64), blocks = (resolution + size - 1) / size;
        std::vector<double> ratio;
        for (int by = 0; by < blocks; ++by)
            for (int bx = 0; bx < blocks; ++bx) {
                double above = 0, below = 0, count = 0;
                for (int y = by * size; y < std::min(resolution, (by + 1) * size); ++y)
                    for (int x = bx * size; x < std::min(resolution, (bx + 1) * size); ++x) {
                        const size_t i = size_t(y) * size_t(resolution) + size_t(x);
                        above += pdf[i];
                        below += density[i];
                        count += side.Of(r_.histogram).count[i];
                    }
                ratio.push_back(count >= 32 && above > 0 ? std::log2(above / below) : std::nan(""));
            }
        const ValueScale ratioScale{-kRatioRange, kRatioRange, false};
        HemispherePlot plot =
            Mapped("pdf over density", "0 where the pdf is exact", blocks, ratioScale,
                   ColorScale::Diverging(), "log2 of the quotient", [ratio](size_t i) { return ratio[i]; });
        plot.note = kTooFew;
        plot.darkGrid = true;
        cells.push_back(Hemisphere(std::move(plot)));
        return cells;
    }

    // ---- Plots ----

    std::vector<Row> PlotRows() const {
        constexpr float kPlotWidth = 2 * kPanel + kGap;
        Row row;
        for (const Side& side : Sides())
            row.push_back({kPlotWidth, [this, side](Canvas& canvas, Vec2 at) {
                               Draw(canvas, SectionPlot(side), at, {kPlotWidth, kPlotHeight});
                           }});
        const Cell albedo{kPlotWidth, [this](Canvas& canvas, Vec2 at) {
                              Draw(canvas, AlbedoPlot(), at, {kPlotWidth, kPlotHeight - 44});
                              DrawSwatches(canvas, at + Vec2(46, kPlotHeight - 40), kPlotWidth - 56);
                          }};
        row.push_back(albedo);
        // Two plots beside each other.
        std::vector<Row> rows;
        for (size_t i = 0; i < row.size(); i += 2)
            rows.emplace_back(row.begin() + std::ptrdiff_t(i),
                              row.begin() + std::ptrdiff_t(std::min(row.size(), i + 2)));
        return rows;
    }

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
                if (glm::dot(p, p) >= 1) continue;
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

    CurvePlot SectionPlot(const Side& side) const {
        CurvePlot plot;
        plot.title = fmt::format("{} in the plane of incidence", side.name);
        plot.subtitle = "f cos θ [1/sr]; negative angles lie on the side of the light";
        plot.xLabel = "angle to the normal";
        plot.x = {-90, 90, false};
        plot.xTicks = {-90, -60, -30, 0, 30, 60, 90};
        plot.y = LogScaleOf(Luminances(side.Of(r_.estimators[0].lobe)));
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
            curve.label = r_.estimators[i].name;
            plot.curves.push_back(curve);
        }
        if (!side.isTransmission) plot.lines.push_back({-std::min(r_.thetaDeg, 180 - r_.thetaDeg), "ωi"});
        return plot;
    }

    CurvePlot AlbedoPlot() const {
        CurvePlot plot;
        plot.title = "Albedo by angle";
        plot.subtitle =
            "part of the light that leaves again, specular peaks included; bars are 95 % intervals";
        plot.x = {0, 90, false};
        plot.xTicks = {0, 15, 30, 45, 60, 75, 90};
        double most = 0.05;
        const RGB primaries[] = {ColorOf(0xf2695c), ColorOf(0x74d07c), ColorOf(0x5f9df5)};
        const char* names[] = {"red", "green", "blue"};
        for (const Side& side : Sides())
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
        furnace.label = "white furnace (luminance)";
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

    /// Luminance of what each estimator finds, with what is specular added from the samples.
    void AddEstimatorDots(CurvePlot& plot) const {
        for (size_t e = 0; e < r_.estimators.size(); ++e)
            for (const Side& side : Sides()) {
                Curve dots;
                dots.color = SheetStyle::Curve(e);
                dots.isLine = false;
                dots.hasDots = true;
                dots.width = 2.4f;
                if (!side.isTransmission) dots.label = r_.estimators[e].name + " (luminance)";
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

    void DrawSwatches(Canvas& canvas, Vec2 at, float width) const {
        float y = at.y;
        for (const Side& side : Sides()) {
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

    // ---- Table ----

    struct Column {
        std::string head;
        float width;
    };
    float TableHeight() const { return 46 + 22 * float(r_.estimators.size() + 1) + 44; }

    void DrawTable(Canvas& canvas, float y) const {
        std::vector<Column> columns{{"", 170}, {"reflected", 150}, {"− samples (95 %)", 200}};
        if (r_.transmits) {
            columns.push_back({"transmitted", 150});
            columns.push_back({"− samples (95 %)", 200});
        }
        for (const Column& c :
             {Column{"white furnace", 130}, {"ns a call", 100}, {"noise of one", 120}, {"reciprocity", 130}})
            columns.push_back(c);
        float end = kMargin;
        for (const Column& c : columns) end += c.width;
        const auto row = [&](const std::vector<std::string>& cells, RGB color) {
            float x = kMargin;
            for (size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
                x += columns[i].width;
                const bool isFirst = i == 0;
                canvas.Text({isFirst ? kMargin : x - 14, y}, 9.5f, color, cells[i],
                            isFirst ? Align::Left : Align::Right);
            }
            y += 22;
        };
        std::vector<std::string> heads;
        for (const Column& c : columns) heads.push_back(c.head);
        y += 12;
        row(heads, style_.faint);
        canvas.Line({kMargin, y - 15}, {end, y - 15}, 1, style_.rule);
        row(SampleCells(), style_.text);
        for (const EstimatorResult& e : r_.estimators) row(EstimatorCells(e), style_.text);
        canvas.Text(
            {kMargin, y + 4}, 8.5f, style_.faint,
            "Luminance of light without specular peaks; ± one standard error; \"!\" where a 95 % interval "
            "leaves out 0 (one in twenty does by chance). table.txt and table.json say more.");
    }

    static std::string Number(const ColorMean& m) {
        return fmt::format("{:.5f} ± {:.0e}", m.Luminance(), m.LuminanceError());
    }
    double FurnaceBySamples() const {
        return r_.sampledFurnace.reflected.Luminance() + r_.sampledFurnace.transmitted.Luminance();
    }

    std::vector<std::string> SampleCells() const {
        std::vector<std::string> cells{"samples", Number(r_.sampled.smoothReflected), ""};
        if (r_.transmits) {
            cells.push_back(Number(r_.sampled.smoothTransmitted));
            cells.push_back("");
        }
        cells.push_back(fmt::format("{:.4f}", FurnaceBySamples()));
        cells.push_back(fmt::format("{:.0f}", r_.estimators[0].cost.sampleNs));
        return cells;
    }

    std::vector<std::string> EstimatorCells(const EstimatorResult& e) const {
        const SampledLobe& s = r_.sampled;
        const auto agreement = [](const ColorMean& a, const ColorMean& b) {
            const Interval i = Agreement(a, b);
            return fmt::format("{:+.1e} ± {:.0e}{}", i.difference, i.halfWidth, i.HoldsZero() ? "" : " !");
        };
        std::vector<std::string> cells{e.name, Number(e.energy.reflected),
                                       agreement(e.energy.reflected, s.smoothReflected)};
        if (r_.transmits) {
            cells.push_back(Number(e.energy.transmitted));
            cells.push_back(agreement(e.energy.transmitted, s.smoothTransmitted));
        }
        const double specular = FurnaceBySamples() - r_.sampledFurnace.smoothReflected.Luminance() -
                                r_.sampledFurnace.smoothTransmitted.Luminance();
        cells.push_back(fmt::format(
            "{:.4f}", e.furnace.reflected.Luminance() + e.furnace.transmitted.Luminance() + specular));
        cells.push_back(fmt::format("{:.0f}", e.cost.evaluateNs));
        cells.push_back(e.cost.noise > 0 ? fmt::format("{:.2f}", e.cost.noise) : "exact");
        cells.push_back(r_.isStochastic ? fmt::format("max {:.1f} σ", e.reciprocity.largestSigmas)
                                        : fmt::format("max {:.0e}", e.reciprocity.maxRelative));
        return cells;
    }

    const BsdfResult& r_;
    const SheetStyle& style_ = SheetStyle::Get();
};

}  // namespace

Image MakeSheet(const BsdfResult& result) { return SheetMaker(result).Make(); }

}  // namespace lacquer
