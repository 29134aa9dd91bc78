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
    /// Where they are, in the coordinates of NearestSites.
    std::vector<std::array<double, 2>> SitePositions() const;
    /// Factors from mean spacings along x and y to the coordinates of NearestSites: 1, but for stretched
    /// cells.
    static double StretchX(CellKind kind);
    static double StretchY(CellKind kind) { return 1 / StretchX(kind); }

  private:
    friend class NearestSites;
    static constexpr int kMaxInBucket = 4;
    struct Site {
        float x, y;  ///< within the bucket: [0,1)
    };
    void PlacePoissonDisc(uint64_t stream);

    CellKind kind_;
    int periodX_, periodY_;
    std::vector<Site> sites_;
    std::vector<int> firstSite_;  ///< of each bucket of one by one, rows of them; one more than buckets
};

/// Finds the nearest sites of points [Worley 1996]. Fastest for one point beside another: it keeps the sites
/// around the last one. For as long as the seed of the cells stays.
class NearestSites {
  public:
    explicit NearestSites(const Cells& cells) : cells_(cells) {}

    struct Nearest {
        int site = 0;           ///< the nearest
        double f1 = 0, f2 = 0;  ///< distances to it and to the second
        double f1ByX = 0, f1ByY = 0, f2ByX = 0, f2ByY = 0;
    };
    /// Any finite x, y.
    Nearest At(double x, double y);

  private:
    static constexpr int kMaxCandidates = 25 * Cells::kMaxInBucket;
    struct Pair;
    void GatherNear(double floorX, double floorY);  ///< sites of the nine buckets around the point's
    void GatherFar();                               ///< and of the sixteen around these
    void AddBucket(int i, int j);
    Pair FindAmong(int count, double fx, double fy) const;

    const Cells& cells_;
    double floorX_ = 0.5, floorY_ = 0.5;        ///< of the last point; none yet
    int column_ = 0, row_ = 0;                  ///< of its bucket
    int count_ = 0;                             ///< of candidates
    int numNear_ = 0;                           ///< of these in the nine buckets around the point
    std::array<double, kMaxCandidates> x_, y_;  ///< from the corner of the bucket
    std::array<int, kMaxCandidates> site_;
};

}  // namespace lacquer::estimate
