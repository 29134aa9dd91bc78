// Where a lobe is: a density for integration, learnt from samples.
#pragma once

#include <span>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::measure {

/// A density over directions that follows given ones however narrow they lie, and is nowhere 0 on the sides
/// that it covers: a quadtree over each projected hemisphere, mixed with the uniform density there. Its pdf
/// is exact, so integrals with it are unbiased whatever it was learnt from.
class DirectionGuide {
  public:
    /// @param upper, lower  whether the hemispheres z > 0 and z < 0 are covered; at least one
    DirectionGuide(std::span<const Vec3> directions, bool upper, bool lower);

    /// A direction with |z| > 0, and its density times pi over |cos theta|: the density that is uniform on
    /// one hemisphere's disk has the value 1.
    struct Draw {
        Vec3 w;
        double diskDensity;
    };
    /// @param u  in [0,1)^4
    Draw Sample(glm::dvec4 u) const;
    /// The same density at a given direction; 0 on sides that are not covered.
    double DiskDensity(Vec3 w) const;

  private:
    struct Node {
        int firstChild = -1;  ///< of four, -1 for a leaf
        int depth = 0;
        Point2 corner{0};    ///< in the unit square that the disk is mapped to
        double density = 0;  ///< of a leaf
        int leaf = -1;       ///< index of a leaf
    };
    void Split(int node, std::span<Point2> points, size_t total, int leafSize);
    const Node& LeafAt(int root, Point2 p) const;

    std::vector<Node> nodes_;
    std::vector<int> leaves_, leafSide_;  ///< nodes, and the sides that they belong to
    std::vector<double> leafEnd_;         ///< running sum of probabilities
    int roots_[2] = {-1, -1};             ///< upper, lower
    double uniform_ = 1;                  ///< share of the uniform density
    int numSides_ = 0;
};

}  // namespace lacquer::measure
