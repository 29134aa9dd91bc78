// Voronoi cells on a torus.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace lacquer::estimate {

enum class CellKind {
    Jittered,     ///< one site in each square of a grid, anywhere in 0.9 of it
    PoissonDisc,  ///< random sites, none closer than 0.8 mean spacings
    Stretched     ///< jittered, cells 1.6 times as long along x as along y
};
constexpr int kNumCellKinds = 3;

/// Sites with a mean density of one per unit of area, periodic.
class Cells {
  public:
    /// @param periodX, periodY  sides of the torus, in mean spacings; at least 5
    Cells(CellKind kind, int periodX, int periodY);
    void SetSeed(uint64_t stream);

    int PeriodX() const { return periodX_; }
    int PeriodY() const { return periodY_; }
    int NumSites() const { return int(sites_.size()); }
    /// Where they are, in the coordinates of NearestTo().
    std::vector<std::array<double, 2>> SitePositions() const;
    /// Factors from mean spacings along x and y to the coordinates of NearestTo(): 1, but for stretched
    /// cells.
    static double StretchX(CellKind kind);
    static double StretchY(CellKind kind) { return 1 / StretchX(kind); }

    struct Nearest {
        int site = 0;           ///< the nearest
        double f1 = 0, f2 = 0;  ///< distances to it and to the second
        double f1ByX = 0, f1ByY = 0, f2ByX = 0, f2ByY = 0;
    };
    /// Any finite x, y [Worley 1996].
    Nearest NearestTo(double x, double y) const;

  private:
    struct Site {
        float x, y;  ///< within the bucket: [0,1)
    };
    struct Search;
    void PlacePoissonDisc(uint64_t stream);
    void Visit(int column, int row, double dx, double dy, Search* search) const;

    CellKind kind_;
    int periodX_, periodY_;
    std::vector<Site> sites_;
    std::vector<int> firstSite_;  ///< of each bucket of one by one, rows of them; one more than buckets
};

}  // namespace lacquer::estimate
