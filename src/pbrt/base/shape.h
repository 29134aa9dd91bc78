// Geometry: one object may hold many primitives (a mesh its triangles).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbrt/base/interaction.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/transform.h"

namespace lacquer {

/// Where a ray meets a primitive. `coordinates` are the primitive's own: barycentric b1, b2 of triangles,
/// (u, v) of patches, whatever Interaction() needs of quadrics.
struct ShapeHit {
    float t = 0;
    Vec2 coordinates{0};
};

/// A point drawn on a primitive.
struct ShapeSample {
    Point3 p{0};
    float pError = 0;
    Normal3 n{0, 0, 1};  ///< geometric, oriented like SurfaceInteraction::n
    Point2 uv{0};
    float pdf = 0;  ///< over area [1/m^2] or over solid angle from the reference point [1/sr]
};

/// Vertices and triangles in the layout that an accelerator can use without a copy.
/// Both arrays are followed by at least 16 readable bytes.
struct TriangleView {
    std::span<const Point3> vertices;
    std::span<const glm::uvec3> triangles;
};

/// A shape in rendering space (or in the space of the object that it is an instance of). Immutable,
/// thread-safe.
class Shape {
  public:
    virtual ~Shape() = default;
    /// Number of primitives; each can be an area light of its own.
    virtual int NumPrimitives() const { return 1; }
    virtual Bounds3 Bounds(int primitive) const = 0;
    /// Nearest intersection with tMin < t < tMax, or empty; exact enough to serve as the reference for
    /// accelerators.
    virtual std::optional<ShapeHit> Intersect(const Ray& ray, float tMin, float tMax,
                                              int primitive) const = 0;
    /// Differential geometry at a hit of `ray`. Fills everything but wo, footprint and bindings;
    /// derivatives of normals are zero where `si` does not want them.
    virtual void Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                             SurfaceInteraction* si) const = 0;
    /// Surface area in rendering space [m^2] (quadrics: before a scaling transform, as pbrt).
    virtual float Area(int primitive) const = 0;
    /// A point drawn uniformly by area. Empty for degenerate primitives.
    virtual std::optional<ShapeSample> SampleArea(int primitive, Point2 u) const = 0;
    /// A point drawn for a reference point, density over solid angle. Default: by area, converted.
    /// @param wantsUv  false: nobody reads the sample's uv, which may then be left out
    virtual std::optional<ShapeSample> SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                        bool wantsUv) const;
    /// Density of SampleSolidAngle for the direction from ref to a point on the primitive with normal n.
    virtual float PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const;
    /// Bounds of the normals of a primitive: axis and cosine of the half angle; (z, -1) means any direction.
    virtual std::pair<Vec3, float> NormalCone(int /*primitive*/) const { return {Vec3(0, 0, 1), -1.f}; }
    /// True if a CTM with scale makes Area() wrong (quadrics): worth a warning for emitters.
    virtual bool AreaIgnoresScale() const { return true; }
    /// Why no area light can have this shape; empty if one can.
    virtual std::string WhyNoEmitter() const { return {}; }
    /// Triangle meshes: their arrays, so that an accelerator can intersect them natively.
    virtual std::optional<TriangleView> Triangles() const { return std::nullopt; }
    /// Bytes of memory held.
    virtual size_t MemoryBytes() const { return sizeof(*this); }
};

/// Density over solid angle at `from` [1/sr] of a point p with normal n that was drawn with density `pdfArea`
/// over area [1/m^2]; 0 where there is none (edge-on or coincident points).
float AreaToSolidAngle(float pdfArea, Point3 from, Point3 p, Normal3 n);

/// What a shape's factory gets: CTM is object to world.
class MeshCache;

struct ShapeArgs {
    const Params& params;
    Transform renderFromObject;
    bool reverseOrientation = false;
    TextureLibrary& textures;
    class Observer* observer = nullptr;  ///< for warnings; may be null
    float displacementEdgeScale = 1;     ///< multiplies the edge length of displaced meshes
    MeshCache* meshes = nullptr;         ///< reads files of meshes; null: they are not kept
};
struct ShapeKind {
    static constexpr const char* kKind = "shape";
    /// One directive can make several shapes (a PLY file with triangles and quads).
    using Factory = std::vector<std::unique_ptr<Shape>> (*)(const ShapeArgs&);
};

}  // namespace lacquer
