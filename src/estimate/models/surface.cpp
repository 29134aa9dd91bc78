#include "estimate/models/surface.h"

namespace lacquer::estimate {

Surface Surface::ZeroAdjoint() const {
    Surface zero;
    zero.reflectance = reflectance;
    zero.height.assign(height.size(), 0.);
    zero.slopeX.assign(slopeX.size(), 0.);
    zero.slopeY.assign(slopeY.size(), 0.);
    zero.roughness.assign(roughness.size(), 0.);
    for (size_t k = 0; k < 3; ++k) zero.albedo[k].assign(albedo[k].size(), 0.);
    return zero;
}

void SlopesOf(const MapGrid& grid, std::span<const double> height, Field* slopeX, Field* slopeY) {
    const size_t n = size_t(grid.size);
    const double scale = 1 / grid.Spacing();
    slopeX->resize(n * n);
    slopeY->resize(n * n);
    for (size_t i = 0; i < n; ++i) {
        const double* row = &height[i * n];
        double* gx = &(*slopeX)[i * n];
        double* gy = &(*slopeY)[i * n];
        for (size_t j = 0; j + 1 < n; ++j) gx[j] = (row[j + 1] - row[j]) * scale;
        gx[n - 1] = grid.isPeriodic ? (row[0] - row[n - 1]) * scale : gx[n - 2];
        const bool isLast = i + 1 == n;
        const double* upper = isLast && !grid.isPeriodic ? row - n : row;
        const double* lower = isLast ? (grid.isPeriodic ? height.data() : row) : row + n;
        for (size_t j = 0; j < n; ++j) gy[j] = (upper[j] - lower[j]) * scale;
    }
}

void SlopesAdjoint(const MapGrid& grid, std::span<const double> byX, std::span<const double> byY,
                   std::span<double> byHeight) {
    const size_t n = size_t(grid.size);
    const double scale = 1 / grid.Spacing();
    for (size_t i = 0; i < n; ++i) {
        double* row = &byHeight[i * n];
        const double* gx = &byX[i * n];
        const double* gy = &byY[i * n];
        for (size_t j = 0; j + 1 < n; ++j) {
            row[j + 1] += gx[j] * scale;
            row[j] -= gx[j] * scale;
        }
        const size_t left = grid.isPeriodic ? n - 1 : n - 2, right = grid.isPeriodic ? 0 : n - 1;
        row[right] += gx[n - 1] * scale;
        row[left] -= gx[n - 1] * scale;
        const bool isLast = i + 1 == n;
        double* upper = isLast && !grid.isPeriodic ? row - n : row;
        double* lower = isLast ? (grid.isPeriodic ? byHeight.data() : row) : row + n;
        for (size_t j = 0; j < n; ++j) {
            upper[j] += gy[j] * scale;
            lower[j] -= gy[j] * scale;
        }
    }
}

}  // namespace lacquer::estimate
