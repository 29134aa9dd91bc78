// Slices of a boundary's BSDF over the plane of slopes, tabulated: what lobes are fitted to.
#pragma once

#include <vector>

#include "gaussfit/lobe/lobe_models.h"

namespace lacquer::gaussfit {

/// Where a slice is taken.
struct SlicePoint {
    double alpha = 0.1;
    double eta = 1;    ///< index on the far side over index on the side of w; not looked at for reflections
    double theta = 0;  ///< angle of w [radians]; its azimuth is 0
};

struct SliceOptions {
    int columns = 96;          ///< cells along x
    int rows = 48;             ///< cells along y, of the half y > 0
    double truncation = 1e-3;  ///< what is below this fraction of the largest value counts as 0
};

/// First and second moments in the plane of slopes. By isotropy the mean of y and the covariance are 0.
struct SliceMoments {
    double meanX = 0, varianceX = 0, varianceY = 0;
};

/// Probabilities of the cells of a grid over x in [x0, x1], y in [0, y1]; y < 0 is the mirror image.
struct Slice {
    double x0 = 0, x1 = 0, y1 = 0;
    int columns = 0, rows = 0;
    std::vector<float> mass;  ///< row by row, sum 1; empty if f is 0 everywhere
    double f = 0;             ///< largest f cos^c of all cells

    double X(int column) const { return x0 + (column + 0.5) * (x1 - x0) / columns; }
    double Y(int row) const { return (row + 0.5) * y1 / rows; }
    float At(int column, int row) const { return mass[size_t(row) * size_t(columns) + size_t(column)]; }
    bool IsEmpty() const { return mass.empty(); }
};

/// Slope of the direction in which a smooth boundary sends light from angle theta, along x: -tan theta for
/// reflections, tan theta_t for transmissions. Infinite under total reflection.
double SpecularSlope(const LobeModel& model, const SlicePoint& point);

/// f(w, v) cos^c of v = +-(slope, 1) for the model's c; w is that of `point`.
double SliceValue(const LobeModel& model, const SlicePoint& point, double x, double y);

/// The slice on a grid that just covers what is above the truncation. Empty if f is 0 wherever it was looked
/// at. Cost: about 10^4 evaluations of f.
Slice TabulateSlice(const LobeModel& model, const SlicePoint& point, const SliceOptions& options);

SliceMoments MomentsOf(const Slice& slice);

}  // namespace lacquer::gaussfit
