// A point where a ray meets a surface, and what is known about it there.
#pragma once

#include "pbrt/core/vec.h"

namespace lacquer {

class Material;
class Light;
class Medium;

/// Media on the two sides of a surface; equal pointers mean that the surface is no boundary.
struct MediumInterface {
    const Medium* inside = nullptr;
    const Medium* outside = nullptr;
};

/// Differential geometry and bindings of a surface point, in rendering space.
struct SurfaceInteraction {
    Point3 p{0};       ///< the point
    float pError = 0;  ///< bound on the absolute error of each coordinate of p
    Normal3 n{0, 0,
              1};  ///< geometric normal, unit, after ReverseOrientation; the side that emits and is "outside"
    Vec3 wo{0, 0, 1};  ///< toward the viewer, unit
    Point2 uv{0};      ///< surface parameters
    Vec3 dpdu{1, 0, 0}, dpdv{0, 1, 0};
    float time = 0;
    int faceIndex = 0;
    /// The frame that shading uses: interpolated normals, bumps. n is unit and in the hemisphere of the
    /// geometric normal.
    struct Shading {
        Normal3 n{0, 0, 1};
        Vec3 dpdu{1, 0, 0}, dpdv{0, 1, 0};
        Vec3 dndu{0}, dndv{0};  ///< zero where they are not wanted
    } shading;
    /// Said before the surface is asked: whether shading.dndu and dndv are. Only bumps read them.
    bool wantsNormalDerivatives = true;

    // Texture footprint: how p and uv change from one pixel to its neighbour; zero where unknown.
    Vec3 dpdx{0}, dpdy{0};
    float dudx = 0, dvdx = 0, dudy = 0, dvdy = 0;

    const Material* material = nullptr;
    const Light* areaLight = nullptr;
    const MediumInterface* mediumInterface = nullptr;
    int object = -1;    ///< index in SceneNames::objects; -1: unknown
    int instance = -1;  ///< index in SceneParts::instances of what placed the surface; -1: none

    /// The medium of a ray that leaves into direction w; `current`, that of the ray that came, where the
    /// surface is no boundary.
    const Medium* MediumToward(Vec3 w, const Medium* current) const {
        if (!mediumInterface || mediumInterface->inside == mediumInterface->outside) return current;
        return Dot(w, n) > 0 ? mediumInterface->outside : mediumInterface->inside;
    }

    /// Sets the geometric and the shading frame alike. `flip` turns the normal of dpdu x dpdv around.
    void SetGeometry(Point3 point, float error, Point2 uvAt, Vec3 du, Vec3 dv, bool flip) {
        p = point;
        pError = error;
        uv = uvAt;
        dpdu = du;
        dpdv = dv;
        n = Normalize(Cross(du, dv));
        if (flip) n = -n;
        shading = {n, du, dv, Vec3(0), Vec3(0)};
    }
    /// Replaces the shading frame. With `authoritative`, the geometric normal is turned to the side of ns;
    /// else ns is turned to the side of the geometric normal.
    void SetShading(Normal3 ns, Vec3 du, Vec3 dv, Vec3 nu, Vec3 nv, bool authoritative) {
        if (authoritative)
            n = FaceForward(n, ns);
        else
            ns = FaceForward(ns, n);
        shading = {ns, du, dv, nu, nv};
    }
    /// Fills the texture footprint in uv from dpdx, dpdy by least squares in the tangent plane.
    void ComputeUvFootprint();
};

/// Origin for a ray that leaves p into direction w, moved off the surface past the error of p.
inline Point3 OffsetRayOrigin(Point3 p, float pError, Normal3 n, Vec3 w) {
    const float distance = pError * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    const Vec3 offset = Dot(w, n) < 0 ? -distance * n : distance * n;
    const Point3 o = p + offset;
    // The sum itself rounds: at least one more step away from the surface in each coordinate that moved.
    return o + glm::sign(offset) * (2 * MachineEpsilon * Abs(o) + std::numeric_limits<float>::min());
}

/// Reference point of a light sample: where the light is looked at from. n is zero where there is no surface.
struct LightReference {
    Point3 p{0};
    float pError = 0;
    Normal3 n{0};   ///< geometric
    Normal3 ns{0};  ///< shading

    LightReference() = default;
    explicit LightReference(Point3 point) : p(point) {}
    explicit LightReference(const SurfaceInteraction& si)
        : p(si.p), pError(si.pError), n(si.n), ns(si.shading.n) {}
};

}  // namespace lacquer
