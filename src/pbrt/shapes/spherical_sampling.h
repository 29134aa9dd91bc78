// Triangles and rectangles as seen from a point: solid angles, and directions drawn uniformly in them.
#pragma once

#include <optional>

#include "pbrt/core/vec.h"

namespace lacquer {

/// A triangle (a, b, c) seen from a point. Its vectors are double: next to an edge, what is left of 1 + cos
/// is less than the digits of a float, and to a vertex of a path under the rim of a lamp it is most of the
/// light.
class SphericalTriangle {
  public:
    SphericalTriangle(Point3 from, Point3 a, Point3 b, Point3 c);
    /// [sr], in [0, 2 pi]; 0 where it is degenerate. [Van Oosterom and Strackee 1983]
    float SolidAngle() const { return solidAngle_; }
    /// Barycentric coordinates (b1, b2), the weights of b and c, of a point drawn uniformly by solid angle.
    /// Empty where the triangle is seen edge-on. The map is that of [Arvo 1995].
    std::optional<Vec2> Sample(Point2 u) const;

  private:
    glm::dvec3 a_, b_;          // unit vectors to the corners
    glm::dvec3 edgeB_, edgeC_;  // b - a, c - a
    glm::dvec3 normal_;         // their cross product
    double distanceA_, distanceB_;
    double onePlusCosB_;  // of the angle between a and b
    float solidAngle_ = 0;
};

/// A rectangle seen from a point [Urena et al. 2013]. In doubles as well, for its formulas lose half of their
/// digits for the small solid angles that most emitters have.
class SphericalRectangle {
  public:
    /// @param corner, edgeX, edgeY  the rectangle corner + s edgeX + t edgeY; the edges are at right angles,
    /// not zero
    SphericalRectangle(Point3 from, Point3 corner, Vec3 edgeX, Vec3 edgeY);
    /// [sr]; NaN or 0 where it is seen edge-on.
    double SolidAngle() const { return solidAngle_; }
    /// (s, t) in [0,1]^2 of a point drawn uniformly by solid angle.
    Vec2 Sample(Point2 u) const;

  private:
    double x0_, x1_, y0_, y1_,
        z0_;  // extent in a frame along the edges with the viewer at the origin, z0 <= 0
    double b0_, b1_, k_;
    double solidAngle_;
};

}  // namespace lacquer
