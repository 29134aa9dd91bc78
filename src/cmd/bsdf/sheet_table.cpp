// The table of the contact sheet.
#include <fmt/format.h>

#include <algorithm>

#include "cmd/bsdf/sheet_parts.h"

namespace lacquer::cmd {

using namespace measure;
using namespace plot;

namespace {

constexpr float kLineHeight = 22;

struct Column {
    std::string head;
    float width;
};

class TableMaker {
  public:
    explicit TableMaker(const BsdfResult& result) : r_(result) {}

    void Draw(Canvas& canvas, Vec2 at) const {
        float y = at.y;
        std::vector<Column> columns{{"", 170}, {"reflected", 150}, {"− samples (95 %)", 200}};
        if (r_.transmits) {
            columns.push_back({"transmitted", 150});
            columns.push_back({"− samples (95 %)", 200});
        }
        for (const Column& c :
             {Column{"white furnace", 130}, {"ns a call", 100}, {"noise of one", 120}, {"reciprocity", 130}})
            columns.push_back(c);
        float end = at.x;
        for (const Column& c : columns) end += c.width;
        const auto row = [&](const std::vector<std::string>& cells, RGB color) {
            float x = at.x;
            for (size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
                x += columns[i].width;
                const bool isFirst = i == 0;
                canvas.Text({isFirst ? at.x : x - 14, y}, 9.5f, color, cells[i],
                            isFirst ? Align::Left : Align::Right);
            }
            y += kLineHeight;
        };
        std::vector<std::string> heads;
        for (const Column& c : columns) heads.push_back(c.head);
        y += 12;
        row(heads, style_.faint);
        canvas.Line({at.x, y - 15}, {end, y - 15}, 1, style_.rule);
        row(SampleCells(), style_.text);
        const std::vector<EnergyAgreement> agreements = AgreementsWithSamples(r_);
        for (size_t i = 0; i < r_.estimators.size(); ++i)
            row(EstimatorCells(r_.estimators[i], agreements[i]), style_.text);
        canvas.Text(
            {at.x, y + 4}, 8.5f, style_.faint,
            fmt::format("Luminance of light without specular peaks; ± one standard error; \"!\" where an "
                        "interval leaves out 0 ({} together hold with 95 %: one sheet in twenty has one by "
                        "chance). table.txt and table.json say more.",
                        NumAgreements(r_)));
    }

  private:
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

    std::vector<std::string> EstimatorCells(const EstimatorResult& e, const EnergyAgreement& energies) const {
        const auto agreement = [](const Interval& i) {
            return fmt::format("{:+.1e} ± {:.0e}{}", i.difference, i.halfWidth, i.HoldsZero() ? "" : " !");
        };
        std::vector<std::string> cells{e.name, Number(e.energy.reflected), agreement(energies.reflected)};
        if (r_.transmits) {
            cells.push_back(Number(e.energy.transmitted));
            cells.push_back(agreement(energies.transmitted));
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

void DrawTable(Canvas& canvas, const BsdfResult& result, Vec2 at) { TableMaker(result).Draw(canvas, at); }

float TableHeight(const BsdfResult& result) { return 90 + kLineHeight * float(result.estimators.size() + 1); }

}  // namespace lacquer::cmd
