#include "estimate/layered/measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"

namespace lacquer::estimate {

namespace {

const std::vector<std::string> kAngles = {"theta_i", "phi_i", "theta_o", "phi_o"};
const std::vector<std::string> kColumns = {"theta_i", "phi_i", "theta_o",    "phi_o", "r",
                                           "g",       "b",     "wavelength", "value", "sd"};

/// Beyond these no instrument reaches, and logarithms of values would only tell of the unit.
constexpr double kMinValue = 1e-12, kMaxValue = 1e9;

struct Cell {
    std::string_view text;
    FileLoc loc;
};

std::string_view Trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Why a line has not the expected number of cells, where tables of spreadsheets often differ.
std::string SeparatorHint(std::string_view line) {
    for (const auto& [separator, name] : {std::pair{';', "semicolons"}, std::pair{'\t', "tabs"}})
        if (line.find(separator) != std::string_view::npos)
            return fmt::format(": it has {}; expected commas between columns, and points in numbers", name);
    return "";
}

/// A table of numbers with names over its columns.
class Table {
  public:
    explicit Table(const std::string& path)
        : path_(path), bytes_(ReadFileBytes(path, {}, {.maxBytes = size_t(256) << 20})) {
        std::string_view rest = bytes_.View();
        if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
        for (int line = 1; !rest.empty(); ++line) {
            const size_t end = std::min(rest.find('\n'), rest.size());
            const std::string_view text = rest.substr(0, std::min(end, rest.find('#')));
            if (!Trimmed(text).empty()) AddLine(text, line);
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
        if (names_.empty())
            throw SceneError({path},
                             fmt::format("has no columns; expected a first line with {}, and r,g,b or "
                                         "wavelength,value",
                                         fmt::join(kAngles, ",")));
        if (rows_.empty()) throw SceneError({path}, "has no rows of numbers below its column names");
    }

    size_t NumRows() const { return rows_.size(); }
    bool Has(const std::string& name) const { return Find(name) < names_.size(); }
    const FileLoc& HeaderLoc() const { return headerLoc_; }
    const FileLoc& Loc(size_t row, const std::string& name) const { return rows_[row][Find(name)].loc; }
    /// Errors: SceneError, if the column is not there or the cell is no finite number.
    double Get(size_t row, const std::string& name) const {
        const size_t column = Find(name);
        if (column == names_.size())
            throw SceneError(headerLoc_,
                             fmt::format("there is no column \"{}\"{}", name, DidYouMean(name, names_)));
        const Cell& cell = rows_[row][column];
        double value = 0;
        const auto [end, error] = std::from_chars(cell.text.begin(), cell.text.end(), value);
        if (error != std::errc() || end != cell.text.end() || !std::isfinite(value))
            throw SceneError(cell.loc,
                             fmt::format("{} is \"{}\"; expected a number", name, Excerpt(cell.text)));
        return value;
    }
    void CheckNames() const {
        for (const std::string& name : names_)
            if (std::find(kColumns.begin(), kColumns.end(), name) == kColumns.end())
                throw SceneError(headerLoc_,
                                 fmt::format("unknown column \"{}\"{}; expected some of {}", Excerpt(name),
                                             DidYouMean(name, kColumns), fmt::join(kColumns, ", ")));
    }

  private:
    size_t Find(const std::string& name) const {
        return size_t(std::find(names_.begin(), names_.end(), name) - names_.begin());
    }
    void AddLine(std::string_view line, int number) {
        std::vector<Cell> cells;
        for (size_t begin = 0; begin <= line.size();) {
            const size_t end = std::min(line.find(',', begin), line.size());
            const std::string_view text = Trimmed(line.substr(begin, end - begin));
            const size_t column = text.empty() ? begin : size_t(text.data() - line.data());
            cells.push_back({text, {path_, number, int(column) + 1}});
            begin = end + 1;
        }
        if (names_.empty()) {
            headerLoc_ = {path_, number, 1};
            const std::string hint = SeparatorHint(line);
            if (cells.size() == 1 && !hint.empty())
                throw SceneError(headerLoc_, "cannot tell the columns apart" + hint);
            for (const Cell& cell : cells) names_.emplace_back(cell.text);
            return;
        }
        if (cells.size() != names_.size())
            throw SceneError({path_, number, 1},
                             fmt::format("this row has {} values; expected {}, as the first line has{}",
                                         cells.size(), names_.size(),
                                         cells.size() > names_.size() ? " (numbers are written with points, "
                                                                        "1.5, not with commas)"
                                                                      : SeparatorHint(line)));
        rows_.push_back(std::move(cells));
    }

    std::string path_;
    FileBytes bytes_;
    std::vector<std::string> names_;
    FileLoc headerLoc_;
    std::vector<std::vector<Cell>> rows_;
};

DirectionAngles DirectionsOf(const Table& table, size_t row) {
    const auto angle = [&](const char* name) {
        const double theta = table.Get(row, name);
        if (theta < 0 || theta >= 90)
            throw SceneError(
                table.Loc(row, name),
                fmt::format("{} is {:g} degrees{}; expected an angle from the normal, from 0 to below 90",
                            name, theta, theta > 90 ? ", below the surface" : ""));
        return theta;
    };
    return {angle("theta_i"), table.Get(row, "phi_i"), angle("theta_o"), table.Get(row, "phi_o")};
}

}  // namespace

std::string DirectionAngles::ToString() const {
    return fmt::format("{:.4g}, {:.4g} to {:.4g}, {:.4g}", thetaI, phiI, thetaO, phiO);
}

Vector Measurement::Flat() const { return values.transpose().reshaped(); }
Vector Measurement::RelativeDeviations() const {
    return deviations.cwiseQuotient(values).transpose().reshaped();
}

Measurement ReadMeasurement(const std::string& path) {
    const Table table(path);
    table.CheckNames();
    const bool isSpectral = table.Has("wavelength") || table.Has("value");
    const std::vector<std::string> channels =
        isSpectral ? std::vector<std::string>{"value"} : std::vector<std::string>{"r", "g", "b"};
    if (isSpectral && (table.Has("r") || table.Has("g") || table.Has("b")))
        throw SceneError(table.HeaderLoc(), "has r, g, b and wavelength, value; expected one of the two");
    Measurement m;
    m.values = Matrix::Zero(Eigen::Index(table.NumRows()), Eigen::Index(channels.size()));
    m.deviations = Matrix::Zero(m.values.rows(), m.values.cols());
    for (size_t i = 0; i < table.NumRows(); ++i) {
        const auto row = Eigen::Index(i);
        m.directions.push_back(DirectionsOf(table, i));
        if (isSpectral) {
            m.wavelengths.push_back(table.Get(i, "wavelength"));
            if (!(m.wavelengths.back() >= 360 && m.wavelengths.back() <= 830))
                throw SceneError(
                    table.Loc(i, "wavelength"),
                    fmt::format("wavelength is {:g}; expected 360 to 830 nm", m.wavelengths.back()));
        }
        for (size_t c = 0; c < channels.size(); ++c) {
            const double value = table.Get(i, channels[c]);
            if (!(value > 0) || value < kMinValue || value > kMaxValue)
                throw SceneError(
                    table.Loc(i, channels[c]),
                    value > kMaxValue
                        ? fmt::format("{} is {:g}; expected a reflectance [1/sr] of at most {:g}",
                                      channels[c], value, kMaxValue)
                        : fmt::format("{} is {:g}; expected a positive reflectance [1/sr], at least {:g}: "
                                      "leave out what could not be measured",
                                      channels[c], value, kMinValue));
            m.values(row, Eigen::Index(c)) = value;
        }
        if (!table.Has("sd")) continue;
        const double sd = table.Get(i, "sd");
        if (sd < 0)
            throw SceneError(table.Loc(i, "sd"),
                             fmt::format("sd is {:g}; expected one that is not negative", sd));
        m.deviations.row(row).setConstant(sd);
    }
    return m;
}

std::string Doubt(const Measurement& m) {
    // Of lobes that are all peak the median may be above 1, but not by so much.
    constexpr double kMaxMedian = 10;
    Vector sorted = m.Flat();
    const auto middle = sorted.begin() + sorted.size() / 2;
    std::nth_element(sorted.begin(), middle, sorted.end());
    if (!(*middle > kMaxMedian)) return "";
    return fmt::format(
        "half of the reflectances are above {:.3g}, and a white sheet's is {:.2g} [1/sr]: if these are "
        "percent, or relative to a white standard, they have to be divided",
        *middle, std::numbers::inv_pi);
}

std::vector<DirectionAngles> ReadDirections(const std::string& path) {
    const Table table(path);
    std::vector<DirectionAngles> directions;
    for (size_t i = 0; i < table.NumRows(); ++i) directions.push_back(DirectionsOf(table, i));
    return directions;
}

std::string MeasurementCsv(const Measurement& m, bool withDeviations) {
    std::string text = "theta_i,phi_i,theta_o,phi_o,";
    text += m.IsColor() ? "r,g,b" : "wavelength,value";
    text += withDeviations ? ",sd\n" : "\n";
    for (Eigen::Index i = 0; i < m.NumRows(); ++i) {
        const DirectionAngles& d = m.directions[size_t(i)];
        text += fmt::format("{:.10g},{:.10g},{:.10g},{:.10g}", d.thetaI, d.phiI, d.thetaO, d.phiO);
        if (!m.IsColor()) text += fmt::format(",{:.10g}", m.wavelengths[size_t(i)]);
        for (const double value : m.values.row(i)) text += fmt::format(",{:.9g}", value);
        if (withDeviations) text += fmt::format(",{:.4g}", m.deviations.row(i).mean());
        text += "\n";
    }
    return text;
}

std::vector<DirectionAngles> CandidateDirections() {
    std::vector<DirectionAngles> directions;
    for (const double in : {0., 15., 30., 45., 60., 75.})
        for (const double around : {0., 90., 180.})
            for (const double out : {0., 15., 30., 45., 60., 75.}) {
                // The camera would stand before the light, and at the pole there is one direction only.
                const bool isSame = in == out && (around == 0 || in == 0);
                if (!isSame && (out > 0 || around == 0) && (in > 0 || around == 180 || out == 0))
                    directions.push_back({in, 0, out, around});
            }
    return directions;
}

std::vector<DirectionAngles> LobeDirections() {
    std::vector<DirectionAngles> directions;
    for (const double in : {10., 35., 60.})
        for (const double offset : {-60., -40., -25., -15., -8., -4., 0., 4., 8., 15., 25., 40.}) {
            const double out = in + offset;
            if (std::abs(out) < 80 && std::abs(out + in) > 1)
                directions.push_back({in, 0, std::abs(out), out < 0 ? 0. : 180.});
        }
    return directions;
}

}  // namespace lacquer::estimate
