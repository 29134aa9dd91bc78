#include "materialgan/procedural/cells.h"

#include <cmath>

namespace lacquer::materialgan {
namespace {

/// Along a circle of circumference 1.
double PeriodicDistance(double a, double b) {
    const double d = std::abs(a - b);
    return std::min(d, 1 - d);
}

/// Points by the square of a coarse grid that they lie in, so that few are looked at for each texel.
struct PointGrid {
    int side;
    std::vector<std::array<double, 2>> points;
    std::vector<std::vector<int>> squares;

    PointGrid(int count, Rng& rng) : side(std::max(1, int(std::sqrt(count / 2.)))) {
        squares.resize(size_t(side) * size_t(side));
        for (int i = 0; i < count; ++i) {
            const double x = double(rng.Uniform()), y = double(rng.Uniform());
            points.push_back({x, y});
            squares[size_t(y * side) * size_t(side) + size_t(x * side)].push_back(i);
        }
    }
};

struct Nearest {
    int index = 0;
    double first = 2, second = 2;
    void Add(int i, double distance) {
        if (distance < first) {
            second = first;
            first = distance;
            index = i;
        } else {
            second = std::min(second, distance);
        }
    }
};

/// Rings of squares around the texel's own, until no point beyond them can be nearer.
Nearest FindNearest(const PointGrid& grid, double x, double y) {
    Nearest nearest;
    const int column = int(x * grid.side), row = int(y * grid.side);
    for (int ring = 0; 2 * ring <= grid.side; ++ring) {
        if (nearest.second <= double(ring - 1) / grid.side) break;
        for (int dy = -ring; dy <= ring; ++dy)
            for (int dx = -ring; dx <= ring; ++dx) {
                if (std::max(std::abs(dx), std::abs(dy)) != ring) continue;
                // On an even grid the last ring has its opposite sides in common.
                if (2 * ring == grid.side && (dx == ring || dy == ring)) continue;
                const int c = (column + dx + grid.side) % grid.side, r = (row + dy + grid.side) % grid.side;
                for (const int i : grid.squares[size_t(r) * size_t(grid.side) + size_t(c)])
                    nearest.Add(i, std::hypot(PeriodicDistance(x, grid.points[size_t(i)][0]),
                                              PeriodicDistance(y, grid.points[size_t(i)][1])));
            }
    }
    return nearest;
}

}  // namespace

CellMap MakeCells(int size, int count, Rng& rng) {
    const PointGrid grid(count, rng);
    CellMap cells;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            const Nearest nearest = FindNearest(grid, (column + 0.5) / size, (row + 0.5) / size);
            cells.index.push_back(nearest.index);
            cells.first.push_back(nearest.first);
            cells.second.push_back(nearest.second);
        }
    return cells;
}

}  // namespace lacquer::materialgan
