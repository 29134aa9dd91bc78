// Triangles that share vertices; what trianglemesh and plymesh make.
#pragma once

#include <array>

#include "pbrt/shapes/mesh_arrays.h"

namespace lacquer {

/// Vertices are held once and in rendering space; nothing is held for a triangle but its indices.
class TriangleMesh final : public Shape {
  public:
    struct Arrays {
        VertexArrays vertices;              ///< in rendering space, see VertexArrays::ToRendering
        std::vector<glm::uvec3> triangles;  ///< in range
        std::vector<int> faceIndices;       ///< empty or one for each triangle
    };
    /// @param flip  turns (p1 - p0) x (p2 - p0) around: ReverseOrientation XOR a mirroring transform
    TriangleMesh(Arrays arrays, bool flip);

    int NumPrimitives() const override { return int(arrays_.triangles.size()); }
    Bounds3 Bounds(int primitive) const override;
    /// Coordinates (b1, b2). In double and inclusive of edges; zero-area triangles are never hit.
    std::optional<ShapeHit> Intersect(const Ray& ray, float tMin, float tMax, int primitive) const override;
    void Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                     SurfaceInteraction* si) const override;
    float Area(int primitive) const override;
    std::optional<ShapeSample> SampleArea(int primitive, Point2 u) const override;
    /// As DistantTriangle does; nearer triangles uniformly by solid angle, but by area where that is tiny or
    /// nearly the hemisphere.
    std::optional<ShapeSample> SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                bool wantsUv) const override;
    float PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const override;
    std::pair<Vec3, float> NormalCone(int primitive) const override;
    bool AreaIgnoresScale() const override { return false; }
    std::optional<TriangleView> Triangles() const override;
    size_t MemoryBytes() const override;

  private:
    std::array<Point3, 3> Corners(int primitive) const;
    std::array<Point2, 3> Uvs(int primitive) const;
    /// Interpolated by barycentric coordinates, of any length; zero if vertices have none.
    Normal3 VertexNormal(int primitive, Vec3 b) const;
    /// Unit normal of the plane, on the side of that of the vertices; `cross` is the product of two sides.
    /// Zero if degenerate.
    Normal3 OrientedNormal(Vec3 cross, Normal3 vertexNormal) const;
    ShapeSample SampleAt(int primitive, const std::array<Point3, 3>& corners, Vec3 b, bool wantsUv) const;
    /// From the vertices' S, or along u where that gives none.
    Vec3 ShadingTangent(int primitive, Vec3 b, Vec3 dpdu) const;
    template <class T>
    T Interpolate(const std::vector<T>& values, int primitive, Vec3 b) const {
        const glm::uvec3 v = arrays_.triangles[size_t(primitive)];
        return b.x * values[v.x] + b.y * values[v.y] + b.z * values[v.z];
    }

    Arrays arrays_;
    bool flip_;
};

}  // namespace lacquer
