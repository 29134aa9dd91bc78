#include "gaussfit/fit/slice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lacquer::gaussfit {

namespace {

/// Half of a rectangle of slopes: y in [0, y1].
struct Box {
    double x0, x1, y1;
};

/// f cos^c at the centres of a grid's cells.
struct Samples {
    Box box;
    int columns, rows;
    std::vector<float> values;
    float largest = 0;

    float& At(int column, int row) { return values[size_t(row) * size_t(columns) + size_t(column)]; }
};

Samples Evaluate(const LobeModel& model, const SlicePoint& point, const Box& box, int columns, int rows) {
    Samples s{box, columns, rows, std::vector<float>(size_t(columns) * size_t(rows))};
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double x = box.x0 + (column + 0.5) * (box.x1 - box.x0) / columns;
            const double y = (row + 0.5) * box.y1 / rows;
            const float value = float(SliceValue(model, point, x, y));
            s.At(column, row) = value;
            s.largest = std::max(s.largest, value);
        }
    return s;
}

/// What holds all cells above the threshold, and whether such a cell lies at one of the box's open sides.
struct Extent {
    int columnBegin, columnEnd, rowEnd;
    bool atLeft, atRight, atTop;
};

Extent ExtentOf(Samples& s, double threshold) {
    Extent e{s.columns, 0, 0, false, false, false};
    for (int row = 0; row < s.rows; ++row)
        for (int column = 0; column < s.columns; ++column) {
            if (!(double(s.At(column, row)) > threshold)) continue;
            e.columnBegin = std::min(e.columnBegin, column);
            e.columnEnd = std::max(e.columnEnd, column + 1);
            e.rowEnd = std::max(e.rowEnd, row + 1);
        }
    e.atLeft = e.columnBegin == 0;
    e.atRight = e.columnEnd == s.columns;
    e.atTop = e.rowEnd == s.rows;
    return e;
}

// Coarse grids are enough to find where a slice is.
constexpr int kSearchColumns = 40, kSearchRows = 20;
// A box of slopes larger than this has all but the last thousandth of all directions in it.
constexpr double kLargestSlope = 1e3;

/// A box that all of the slice lies in: the specular direction's neighbourhood, doubled on its open sides
/// until nothing crosses them.
Box GrowBox(const LobeModel& model, const SlicePoint& point, double truncation) {
    const double center = std::clamp(SpecularSlope(model, point), -kLargestSlope / 4, kLargestSlope / 4);
    // A lobe cannot be much narrower than its facets' slopes are spread.
    const double start = 0.5 * point.alpha;
    Box box{center - start, center + start, start};
    for (int i = 0; i < 40; ++i) {
        Samples s = Evaluate(model, point, box, kSearchColumns, kSearchRows);
        const Extent e = ExtentOf(s, truncation * double(s.largest));
        const bool isEmpty = s.largest == 0;
        if (!isEmpty && !e.atLeft && !e.atRight && !e.atTop) return box;
        const double width = box.x1 - box.x0;
        if (isEmpty || e.atLeft) box.x0 = std::max(box.x0 - 0.5 * width, -kLargestSlope);
        if (isEmpty || e.atRight) box.x1 = std::min(box.x1 + 0.5 * width, kLargestSlope);
        if (isEmpty || e.atTop) box.y1 = std::min(2 * box.y1, kLargestSlope);
    }
    return box;
}

/// The box without its empty margins, which may be a large part of it after growing.
Box ShrinkBox(const LobeModel& model, const SlicePoint& point, double truncation, Box box) {
    for (int i = 0; i < 4; ++i) {
        Samples s = Evaluate(model, point, box, kSearchColumns, kSearchRows);
        if (s.largest == 0) return box;
        const Extent e = ExtentOf(s, truncation * double(s.largest));
        const double dx = (box.x1 - box.x0) / s.columns, dy = box.y1 / s.rows;
        const Box smaller{box.x0 + std::max(0, e.columnBegin - 1) * dx,
                          box.x0 + std::min(s.columns, e.columnEnd + 1) * dx,
                          std::min(s.rows, e.rowEnd + 1) * dy};
        const bool isTight = smaller.x1 - smaller.x0 > 0.8 * (box.x1 - box.x0) && smaller.y1 > 0.8 * box.y1;
        box = smaller;
        if (isTight) break;
    }
    return box;
}

}  // namespace

double SpecularSlope(const LobeModel& model, const SlicePoint& point) {
    if (!model.Transmits()) return -std::tan(point.theta);
    const double sine = std::sin(point.theta) / point.eta;
    return sine < 1 ? sine / std::sqrt(1 - sine * sine) : std::numeric_limits<double>::infinity();
}

double SliceValue(const LobeModel& model, const SlicePoint& point, double x, double y) {
    const double cosine = 1 / std::sqrt(1 + x * x + y * y), sign = model.Transmits() ? -1 : 1;
    const Vec3 w(float(std::sin(point.theta)), 0, float(std::cos(point.theta)));
    const Vec3 v(float(sign * x * cosine), float(sign * y * cosine), float(sign * cosine));
    double value = double(model.f(float(point.alpha), float(point.eta), w, v));
    for (int i = 0; i < model.cosinePower; ++i) value *= cosine;
    return value;
}

Slice TabulateSlice(const LobeModel& model, const SlicePoint& point, const SliceOptions& options) {
    const Box box = ShrinkBox(model, point, options.truncation, GrowBox(model, point, options.truncation));
    Samples s = Evaluate(model, point, box, options.columns, options.rows);
    if (s.largest == 0) return {};
    Slice slice{box.x0,           box.x1, box.y1, options.columns, options.rows, std::move(s.values),
                double(s.largest)};

    // Truncate and normalise.
    double sum = 0;
    for (float& value : slice.mass) {
        if (!(double(value) > options.truncation * slice.f)) value = 0;
        sum += double(value);
    }
    for (float& value : slice.mass) value = float(double(value) / sum);
    return slice;
}

SliceMoments MomentsOf(const Slice& slice) {
    SliceMoments m;
    for (int row = 0; row < slice.rows; ++row)
        for (int column = 0; column < slice.columns; ++column) {
            const double p = double(slice.At(column, row)), x = slice.X(column), y = slice.Y(row);
            m.meanX += p * x;
            m.varianceX += p * x * x;
            m.varianceY += p * y * y;
        }
    m.varianceX -= m.meanX * m.meanX;
    // The mass of a cell is spread over it: Sheppard's correction with the other sign.
    m.varianceX += std::pow((slice.x1 - slice.x0) / slice.columns, 2) / 12;
    m.varianceY += std::pow(slice.y1 / slice.rows, 2) / 12;
    return m;
}

}  // namespace lacquer::gaussfit
