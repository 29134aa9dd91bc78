// Hard spheres in a ball or in a periodic box.
#pragma once

#include <vector>

#include "bulk/ensembles/random.h"

namespace lacquer::bulk {

/// Where spheres may be, about the origin.
struct Domain {
    enum class Kind {
        Ball,        ///< whole spheres within the radius `size`
        PeriodicBox  ///< of side `size`, its sides joined to the opposite ones
    };
    Kind kind = Kind::Ball;
    double size = 1;

    double Volume() const;
    /// From a to b, the shortest way.
    Point Displacement(const Point& a, const Point& b) const;
    /// Back into the box.
    Point Wrap(const Point& p) const;
    bool Contains(const Point& center, double radius) const {
        return kind == Kind::PeriodicBox ? 2 * radius <= size : center.norm() + radius <= size;
    }
    Point RandomPoint(Random& random) const;
};

/// Spheres that do not overlap, with cells to find neighbours.
class HardSpheres {
  public:
    /// @param radii       of all that will be there
    /// @param separation  least distance of two centres over the sum of their radii
    HardSpheres(const Domain& domain, std::vector<double> radii, double separation = 1);
    /// Puts each of them at random where it does not overlap those before it: random sequential addition. In
    /// the order of the radii: give the larger ones first, which find places less easily. False if one found
    /// no place in `maxTries`.
    bool AddAll(Random& random, int maxTries = 20000);
    /// The same where that finds no places: with smaller spheres first, which move at random and grow.
    bool AddAllByGrowth(Random& random);
    /// Random moves until `perSphere` of them were accepted for each sphere on average [Metropolis et al.
    /// 1953]: the equilibrium of hard spheres.
    void Move(Random& random, int perSphere);
    /// Adds the next sphere, in the order of the radii, if there is room.
    bool AddAt(const Point& center);

    int Count() const { return int(centers_.size()); }
    const std::vector<Point>& Centers() const { return centers_; }

  private:
    double Radius(size_t i) const { return scale_ * radii_[i]; }
    bool IsFree(const Point& center, size_t sphere) const;
    int CellOf(const Point& p) const;
    template <class Visitor>
    void VisitNeighbors(const Point& p, const Visitor& visit) const;
    void Insert(size_t sphere, const Point& center);
    void MoveTo(size_t sphere, const Point& center);
    int Sweep(Random& random, double step);
    double LargestScale() const;

    Domain domain_;
    std::vector<double> radii_;
    double separation_, scale_ = 1;
    int cellsPerSide_;
    double cellSize_;
    std::vector<Point> centers_;
    std::vector<std::vector<int>> cells_;
};

}  // namespace lacquer::bulk
