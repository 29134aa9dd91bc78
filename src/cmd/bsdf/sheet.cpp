#include "cmd/bsdf/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "cmd/bsdf/sheet_parts.h"
#include "plot/plot.h"

namespace lacquer::cmd {

using namespace measure;
using namespace plot;

namespace {

constexpr float kPanel = 320, kGap = 26, kMargin = 36, kHeader = 92;
constexpr float kRowHeight = kTitleHeight + kPanel + kBarHeight + 22;
constexpr float kPlotHeight = 380, kPlotRow = kPlotHeight + 20;
constexpr float kSectionTitle = 36, kBlockGap = 56, kMinWidth = 1300;
constexpr double kSigmaRange = 4, kRatioRange = 3;
constexpr const char* kTooFew = "grey: too few samples";

/// Something that stands in a row.
struct Cell {
    float width = 0;
    std::function<void(Canvas&, Vec2)> draw;
};
using Row = std::vector<Cell>;

std::string DegreesText(double v) { return fmt::format("{:.4g}°", v); }

std::string EnergyText(const ColorMean& m) {
    return fmt::format("energy {:.4f} ± {:.1g}", m.Luminance(), m.LuminanceError());
}

std::string NoiseText(const Difference& d) {
    if (d.numBlocks == 0) return "nothing that could be compared";
    return fmt::format("rms {:.2f} σ in {} blocks (noise alone: 1)  ·  σ = {:.2g} %", d.rms, d.numBlocks,
                       100 * d.medianNoise);
}

class SheetMaker {
  public:
    explicit SheetMaker(const BsdfResult& result) : r_(result) {}

    Image Make() {
        // The sides stand beside each other, with the same rows.
        std::vector<std::vector<Row>> blocks;
        for (const SheetSide& side : SidesOf(r_)) blocks.push_back(RowsOf(side));
        const std::vector<Row> plots = PlotRows();
        // Measure, then draw.
        float blockWidth = 0, plotWidth = kMinWidth;
        for (const Row& row : blocks[0]) blockWidth = std::max(blockWidth, WidthOf(row));
        for (const Row& row : plots) plotWidth = std::max(plotWidth, WidthOf(row));
        const float blocksWidth = float(blocks.size()) * (blockWidth + kBlockGap) - kBlockGap;
        const float width = std::max(blocksWidth, plotWidth) + 2 * kMargin;
        const float height = kHeader + 2 * kSectionTitle + float(blocks[0].size()) * kRowHeight +
                             float(plots.size()) * kPlotRow + TableHeight(r_);
        Canvas canvas{int(width), int(height), style_.background};
        DrawHeader(canvas);
        float x = kMargin;
        for (size_t b = 0; b < blocks.size(); ++b) {
            float y = DrawSectionTitle(canvas, SidesOf(r_)[b].name, x, blockWidth, kHeader);
            for (const Row& row : blocks[b]) {
                DrawRow(canvas, row, {x, y});
                y += kRowHeight;
            }
            x += blockWidth + kBlockGap;
        }
        float y = kHeader + kSectionTitle + float(blocks[0].size()) * kRowHeight;
        y = DrawSectionTitle(canvas, "Sections, albedo and numbers", kMargin, width - 2 * kMargin, y);
        for (const Row& row : plots) {
            DrawRow(canvas, row, {kMargin, y});
            y += kPlotRow;
        }
        DrawTable(canvas, r_, {kMargin, y});
        return canvas.AsImage();
    }

    /// One estimator alone: for each side its lobe, and how it differs from the histogram.
    Image MakeLobe(size_t estimator) {
        std::vector<Row> rows;
        for (const SheetSide& side : SidesOf(r_))
            rows.push_back({LobeCell(side, estimator, true), DifferenceCell(side, estimator)});
        const float width = WidthOf(rows[0]) + 2 * kMargin;
        Canvas canvas{int(width), int(float(rows.size()) * (kSectionTitle + kRowHeight) + kMargin),
                      style_.background};
        float y = kMargin / 2;
        for (size_t i = 0; i < rows.size(); ++i) {
            const std::string title = fmt::format("{}, {}", r_.material, SidesOf(r_)[i].name);
            y = DrawSectionTitle(canvas, title, kMargin, width - 2 * kMargin, y);
            DrawRow(canvas, rows[i], {kMargin, y});
            y += kRowHeight;
        }
        return canvas.AsImage();
    }

  private:
    static float WidthOf(const Row& row) {
        float width = 0;
        for (const Cell& cell : row) width += cell.width + kGap;
        return width - kGap;
    }
    static void DrawRow(Canvas& canvas, const Row& row, Vec2 at) {
        for (const Cell& cell : row) {
            cell.draw(canvas, at);
            at.x += cell.width + kGap;
        }
    }

    void DrawHeader(Canvas& canvas) const {
        const float end =
            kMargin + canvas.Text({kMargin, 46}, 20, style_.text, r_.material, Align::Left, true);
        canvas.Text({end + 14, 46}, 13, style_.faint, fmt::format("{} in {}", r_.type, r_.scene));
        const std::string pdf = r_.pdfName.empty() ? "" : fmt::format("  ·  pdf {}", r_.pdfName);
        canvas.Text(
            {kMargin, 72}, 10.5f, style_.faint,
            fmt::format("light from ωi = (θ {}, φ {})  ·  f cos θ of the outgoing direction, seen from "
                        "above  ·  uv ({:.3g}, {:.3g}){}  ·  {} samples a pixel, {:.3g} million in "
                        "histograms",
                        DegreesText(r_.thetaDeg), DegreesText(r_.phiDeg), r_.uv.x, r_.uv.y, pdf,
                        r_.samplesPerPixel, double(r_.histogramSamples) * 1e-6));
    }

    /// @return  where the content of the section begins
    float DrawSectionTitle(Canvas& canvas, const std::string& title, float x, float width, float y) const {
        const float end = x + canvas.Text({x, y + 16}, 14, style_.accent, title, Align::Left, true);
        canvas.Line({end + 14, y + 10}, {x + width, y + 10}, 1, style_.rule);
        return y + kSectionTitle;
    }

    /// What to point out on one side.
    std::vector<PlotMark> MarksOf(const SheetSide& side, bool withLabels) const {
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

    /// An image of numbers on a scale.
    HemispherePlot Mapped(const std::string& title, const std::string& subtitle, int resolution,
                          const ValueScale& scale, const ColorScale& colors, const std::string& unit,
                          const std::function<double(size_t)>& value) const {
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

    std::vector<Row> RowsOf(const SheetSide& side) const {
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

    /// Rows of at most five images.
    static std::vector<Row> Wrap(const Row& cells) {
        constexpr int kMax = 5;
        std::vector<Row> rows(1);
        for (const Cell& cell : cells) {
            if (rows.back().size() == kMax) rows.emplace_back();
            rows.back().push_back(cell);
        }
        return rows;
    }

    /// The scale of all lobes on one side.
    ValueScale LobeScale(const SheetSide& side) const {
        return LogScaleOf(RangeOf(side.Of(r_.estimators[0].lobe), r_.isStochastic));
    }

    Cell LobeCell(const SheetSide& side, size_t estimator, bool withLabels) const {
        const EstimatorResult& e = r_.estimators[estimator];
        const LobeImage& image = side.Of(e.lobe);
        HemispherePlot plot = Mapped(e.name, EnergyText(side.Of(e.energy)), image.resolution, LobeScale(side),
                                     ColorScale::Sequential(), "f cos θ [1/sr]",
                                     [&image](size_t i) { return image.LuminanceAt(i); });
        plot.labelsAngles = withLabels;
        plot.marks = MarksOf(side, withLabels);
        return Hemisphere(std::move(plot));
    }

    Row LobeCells(const SheetSide& side) const {
        Row cells;
        for (size_t i = 0; i < r_.estimators.size(); ++i) cells.push_back(LobeCell(side, i, i == 0));
        const LobeImage& histogram = side.Of(r_.histogram);
        HemispherePlot plot =
            Mapped("histogram of Sample()", EnergyText(side.SmoothOf(r_.sampled)), histogram.resolution,
                   LobeScale(side), ColorScale::Sequential(), "f cos θ [1/sr]",
                   [&histogram](size_t i) { return histogram.LuminanceAt(i); });
        plot.marks = MarksOf(side, false);
        cells.push_back(Hemisphere(std::move(plot)));
        return cells;
    }

    Cell DifferenceCell(const SheetSide& side, size_t estimator) const {
        const EstimatorResult& e = r_.estimators[estimator];
        const Difference& d = side.DifferenceOf(e);
        const ValueScale scale{-kSigmaRange, kSigmaRange, false};
        HemispherePlot plot =
            Mapped(fmt::format("{} − histogram", e.name), NoiseText(d), d.resolution, scale,
                   ColorScale::Diverging(), "σ of the difference", [&d](size_t i) { return d.sigmas[i]; });
        plot.note = kTooFew;
        plot.darkGrid = true;
        return Hemisphere(std::move(plot));
    }

    Row DifferenceCells(const SheetSide& side) const {
        Row cells;
        for (size_t i = 0; i < r_.estimators.size(); ++i) cells.push_back(DifferenceCell(side, i));
        cells.push_back(ColorCell(side));
        return cells;
    }

    /// The lobe as colours, compressed so that peak and tail both show.
    Cell ColorCell(const SheetSide& side) const {
        const LobeImage& image = side.Of(r_.estimators[0].lobe);
        const std::vector<double> values = RangeOf(image, r_.isStochastic);
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

    Row DensityCells(const SheetSide& side) const {
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
        for (const SheetSide& side : SidesOf(r_))
            row.push_back({kPlotWidth, [this, side](Canvas& canvas, Vec2 at) {
                               Draw(canvas, SectionPlot(r_, side), at, {kPlotWidth, kPlotHeight});
                           }});
        const Cell albedo{kPlotWidth, [this](Canvas& canvas, Vec2 at) {
                              Draw(canvas, AlbedoPlot(r_), at, {kPlotWidth, kPlotHeight - 44});
                              DrawSwatches(canvas, r_, at + Vec2(46, kPlotHeight - 40), kPlotWidth - 56);
                          }};
        row.push_back(albedo);
        // As many beside each other as images above allow: all three where there are two sides.
        const size_t perRow = r_.transmits ? 3 : 2;
        std::vector<Row> rows;
        for (size_t i = 0; i < row.size(); i += perRow)
            rows.emplace_back(row.begin() + std::ptrdiff_t(i),
                              row.begin() + std::ptrdiff_t(std::min(row.size(), i + perRow)));
        return rows;
    }

    const BsdfResult& r_;
    const SheetStyle& style_ = SheetStyle::Get();
};

}  // namespace

Image MakeSheet(const BsdfResult& result) { return SheetMaker(result).Make(); }

Image MakeLobeImage(const BsdfResult& result, size_t estimator) {
    return SheetMaker(result).MakeLobe(estimator);
}

}  // namespace lacquer::cmd
