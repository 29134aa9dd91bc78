// Bilinear patches that share vertices; what bilinearmesh and the quads of plymesh make.
#pragma once

#include "pbrt/shapes/mesh_arrays.h"

namespace lacquer {

/// Patches p(u, v) = (1-u)(1-v) p00 + u (1-v) p10 + (1-u) v p01 + u v p11. Vertices are held once and in
/// rendering space; nothing is held for a patch but its indices.
class BilinearMesh final : public Shape {
  public:
    struct Arrays {
        VertexArrays vertices;            ///< in rendering space, see VertexArrays::ToRendering
        std::vector<glm::uvec4> patches;  ///< p00, p10, p01, p11; in range
        std::vector<int> faceIndices;     ///< empty or one for each patch
    };
    /// @param flip  turns dpdu x dpdv around: ReverseOrientation XOR a mirroring transform
    BilinearMesh(Arrays arrays, bool flip) : arrays_(std::move(arrays)), flip_(flip) {}

    int NumPrimitives() const override { return int(arrays_.patches.size()); }
    Bounds3 Bounds(int primitive) const override;
    /// Coordinates (u, v). In double and inclusive of edges.
    std::optional<ShapeHit> Intersect(const Ray& ray, float tMin, float tMax, int primitive) const override;
    void Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                     SurfaceInteraction* si) const override;
    /// By quadrature where the patch is no parallelogram; relative error below 1e-4 unless it is nearly
    /// folded.
    float Area(int primitive) const override;
    /// Density proportional to the bilinear function of the area elements at the corners.
    std::optional<ShapeSample> SampleArea(int primitive, Point2 u) const override;
    /// Rectangles uniformly by solid angle where that is neither tiny nor nearly the hemisphere, else by
    /// area.
    std::optional<ShapeSample> SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                bool wantsUv) const override;
    float PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const override;
    std::pair<Vec3, float> NormalCone(int primitive) const override;
    bool AreaIgnoresScale() const override { return false; }
    size_t MemoryBytes() const override;

  private:
    struct Patch {
        Point3 p00, p10, p01, p11;
        Vec3 DpDu(float v) const { return (1 - v) * (p10 - p00) + v * (p11 - p01); }
        Vec3 DpDv(float u) const { return (1 - u) * (p01 - p00) + u * (p11 - p10); }
        Vec3 Cross(float u, float v) const { return lacquer::Cross(DpDu(v), DpDv(u)); }
        bool IsParallelogram() const;
        bool IsRectangle() const;
    };
    Patch Corners(int primitive) const;
    /// dpdu x dpdv, unit and oriented, by the vertex normals where there are any. Zero if degenerate.
    Normal3 OrientedNormal(int primitive, const Patch& patch, Point2 uv) const;
    ShapeSample SampleAt(int primitive, const Patch& patch, Point2 uv) const;
    /// Density over area of SampleArea at (u, v); 0 if degenerate.
    static float PdfArea(const Patch& patch, Point2 uv);
    void SetShadingFrame(int primitive, Point2 uv, const glm::mat2& dUvDst, SurfaceInteraction* si) const;
    template <class T>
    T Interpolate(const std::vector<T>& values, int primitive, Point2 uv) const {
        const glm::uvec4 v = arrays_.patches[size_t(primitive)];
        return (1 - uv.x) * ((1 - uv.y) * values[v.x] + uv.y * values[v.z]) +
               uv.x * ((1 - uv.y) * values[v.y] + uv.y * values[v.w]);
    }
    /// Derivatives over u and v of the same.
    template <class T>
    std::pair<T, T> Derivatives(const std::vector<T>& values, int primitive, Point2 uv) const {
        const glm::uvec4 v = arrays_.patches[size_t(primitive)];
        return {(1 - uv.y) * (values[v.y] - values[v.x]) + uv.y * (values[v.w] - values[v.z]),
                (1 - uv.x) * (values[v.z] - values[v.x]) + uv.x * (values[v.w] - values[v.y])};
    }

    Arrays arrays_;
    bool flip_;
};

}  // namespace lacquer
